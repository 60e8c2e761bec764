"""Describe a lesson's path: scenes that each show one thing and ask for one action.

A scene is a patch on the design: it names what is shown and which knobs it sets. All else stays as the person left it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Literal, get_args

from .design import Design

MAX_KNOBS, MAX_FIGURES = 3, 2  # in sight in one scene
MAX_TEXT_WORDS, MAX_TITLE_WORDS = 45, 6  # of a scene's text and title
PLACE = re.compile(r"\[\[(\w+)(?::([^\]]*))?\]\]")  # [[name]] or [[name:.3g]]: a live number in a scene's words


class Question(Enum):
    """Whose options a scene offers: its own, or those of the lesson's first or second prediction."""

    OWN = "own"
    FIRST = "predict"
    SECOND = "again"


@dataclass(frozen=True)
class Read:
    """Nothing to do but read and look."""


@dataclass(frozen=True)
class Choose:
    """Choose an option. `answer` is the index of the right one; for a prediction the lesson knows it."""

    question: Question = Question.OWN
    answer: int = 0


Way = Literal["", "left", "right"]


@dataclass(frozen=True)
class Goal:
    """Where a moved knob must end: farther than on entry in a direction, within bounds, or at one value.

    Of poles the real part of the slowest one counts: `right` is toward the imaginary axis. `least` and `most` are bounds of the
    number that is meant; `value` is that of a choice or a switch.
    """

    way: Way = ""
    least: float | None = None
    most: float | None = None
    value: Any = None


@dataclass(frozen=True)
class Move:
    """Move one of these knobs, or drag one of its poles; with a `goal` until the first of them has reached it."""

    knobs: tuple[str, ...]
    goal: Goal | None = None


@dataclass(frozen=True)
class Press:
    """Press a button of the run, kick or play, or pull the plant."""

    button: str


@dataclass(frozen=True)
class Solve:
    """Solve a task of the lesson; the page checks it whenever the knobs rest."""

    task: str


Do = Read | Choose | Move | Press | Solve
Camera = Literal[  # from where the stage is seen
    "all", "map", "plant", "bare", "boards", "near", "left", "right", "above", "low", "low left", "low right", "table"]


@dataclass(frozen=True)
class Scene:
    """One stop of a path: what is shown, what is set, what the person does, what the page performs.

    `set` holds knob values on entering. `play` holds the values to which the page moves knobs, visibly, before it gives its verdict;
    `runs` says that the run then plays from its start. `figures` and `boards` are ids; `formulas` the ids of live equations; `lines`
    are lines of algebra in LaTeX that come one after another, see `guide/scene_card.py`. `minutes` is the planned time, `core`
    whether the scene belongs to the path of 15 minutes. `moment` is the share of the run at which it rests, None where plant and
    estimate differ most; `told` is another such share once its question has been answered.
    """

    id: str
    do: Do = field(default_factory=Read)
    set: Mapping[str, Any] = field(default_factory=dict)
    play: Mapping[str, Any] = field(default_factory=dict)
    knobs: tuple[str, ...] = ()
    figures: tuple[str, ...] = ()
    boards: tuple[str, ...] = ()
    formulas: tuple[str, ...] = ()
    runs: bool = True
    camera: str = ""
    minutes: float = 2.0
    core: bool = True
    lines: tuple[str, ...] = ()
    moment: float | None = None
    told: float | None = None

    @property
    def answers(self) -> bool:
        """Whether it asks for something whose run is kept, or performs something."""
        return not isinstance(self.do, Read) or bool(self.play)

    @property
    def view(self) -> str:
        """From where the scene is seen: everything where it shows boards, else the plant."""
        return self.camera or ("all" if self.boards else "plant")


@dataclass(frozen=True)
class SceneWords:
    """The words of a scene in one language; `do` names the action, `say` is said once it is done, `note` is the speaker's."""

    title: str
    text: str
    options: tuple[str, ...] = ()
    refutations: tuple[str, ...] = ()
    do: str = ""
    say: str = ""
    note: str = ""


NO_PATH: tuple[Scene, ...] = ()


def knobs_of(path: Sequence[Scene]) -> frozenset[str]:
    """The knobs that a path touches: those that its scenes set, move or offer."""
    return frozenset(name for scene in path for name in (*scene.set, *scene.play, *scene.knobs, *_moved(scene)))


def _moved(scene: Scene) -> tuple[str, ...]:
    return scene.do.knobs if isinstance(scene.do, Move) else ()


def entry_values(path: Sequence[Scene], index: int, start: Design) -> dict[str, Any]:
    """The values of the path's knobs on entering a scene: what the scenes up to it have set and performed, else the default.

    They do not depend on the way by which the scene was reached, so that a path walked forth and back shows the same states.
    """
    values = {name: start[name] for name in knobs_of(path)}
    for scene in path[:index]:
        values |= {**scene.set, **scene.play}
    return values | dict(path[index].set)


def fill_numbers(words: str, number: Callable[[str, str], str]) -> str:
    """Words with the live numbers in their places `[[name]]`, `[[name:format]]` or `[[name:format unit]]`."""
    return PLACE.sub(lambda place: number(place[1], place[2] or ".3g"), words)


def places_of(words: str) -> tuple[str, ...]:
    """The names of the live numbers of a text."""
    return tuple(name for name, _ in PLACE.findall(words))


def minutes_of(path: Sequence[Scene], core: bool) -> float:
    """The planned minutes of a path, or of its core."""
    return sum(scene.minutes for scene in path if scene.core or not core)


Mode = Literal["guide", "lab", "present"]  # how a lesson is shown: scene by scene, all at once, or scene by scene for a hall
MODES: tuple[Mode, ...] = get_args(Mode)
