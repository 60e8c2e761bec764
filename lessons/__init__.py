"""List the lessons in the order in which they are taught."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType

from observer_lab.course.glossary import Glossary, glossaries_in
from observer_lab.course.lesson import Lesson

from .arm.lesson import LESSON as arm
from .bilinear_observer.lesson import LESSON as bilinear_observer
from .decoupling.lesson import LESSON as decoupling
from .duality.lesson import LESSON as duality
from .error_dynamics.lesson import LESSON as error_dynamics
from .fault_diagnosis.lesson import LESSON as fault_diagnosis
from .hidden_modes.lesson import LESSON as hidden_modes
from .kalman.lesson import LESSON as kalman
from .lqg.lesson import LESSON as lqg
from .network.lesson import LESSON as network
from .noise.lesson import LESSON as noise
from .nonlinear.lesson import LESSON as nonlinear
from .observability.lesson import LESSON as observability
from .record.lesson import LESSON as record
from .robust_observer.lesson import LESSON as robust_observer
from .sandbox.lesson import LESSON as sandbox
from .saturation.lesson import LESSON as saturation
from .separation.lesson import LESSON as separation
from .showdown.lesson import LESSON as showdown
from .virtual_sensor.lesson import LESSON as virtual_sensor
from .weak_states.lesson import LESSON as weak_states

LESSONS: MappingProxyType[str, Lesson] = MappingProxyType({lesson.id: lesson for lesson in sorted((
    virtual_sensor,
    error_dynamics,
    observability,
    separation,
    duality,
    hidden_modes,
    saturation,
    noise,
    kalman,
    lqg,
    decoupling,
    weak_states,
    nonlinear,
    showdown,
    robust_observer,
    bilinear_observer,
    network,
    fault_diagnosis,
    sandbox,
    arm,
    record,
), key=lambda lesson: lesson.number)})
FIRST = "virtual-sensor"  # the lesson that a newcomer is led into
OPENING = "separation"  # the lesson that the page opens on


def folder(id: str) -> Path:
    """Where a lesson's code and English words stand."""
    return Path(__file__).parent / id.replace("-", "_")


def draft_folders() -> tuple[Path, ...]:
    """The folders with a `lesson.py` that the table above does not name: drafts, by name."""
    named = {folder(id) for id in LESSONS}
    return tuple(sorted(path.parent for path in Path(__file__).parent.glob("*/lesson.py") if path.parent not in named))


@lru_cache(maxsize=1)
def all_lessons() -> MappingProxyType[str, Lesson]:
    """The lessons of the course, and after them the drafts."""
    drafts = (import_module(f"{__name__}.{place.name}.lesson").LESSON for place in draft_folders())
    return MappingProxyType({**LESSONS, **{draft.id: draft for draft in drafts}})


def glossaries() -> Mapping[str, Glossary]:
    """The glossary of all lessons by language. Raises ProseError."""
    return glossaries_in(Path(__file__).parent)
