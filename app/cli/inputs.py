"""What commands are given: lessons by name, plants and designs from files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lessons import LESSONS

from ..engine import EngineError, load_plant
from ..lesson.knobs import KnobError
from ..lesson.lesson import Design, Lesson, Outcome
from ..plants.examples import EXAMPLES, example
from ..plants.own import canonical
from ..tab.state import read_design
from .options import CommandError, cause

LARGEST = 10_000_000  # bytes of a file that is read at all


def find_lesson(id: str) -> Lesson:
    """The lesson of that id. Raises CommandError naming those there are."""
    if id not in LESSONS:
        raise CommandError(f"There is no lesson {id[:40]}; there are {', '.join(LESSONS)}.")
    return LESSONS[id]


def fitted(lesson: Lesson, plant: str) -> Lesson:
    """The lesson for that plant. Raises CommandError where the two do not fit."""
    try:
        return lesson.fit(plant)
    except (EngineError, KnobError) as problem:
        raise CommandError(str(problem)) from problem


def plant_in(name: str) -> str:
    """The canonical text of the plant in a file, or of an example of that name. Raises CommandError."""
    try:
        if name in EXAMPLES:
            return example(name)
        _plain_file(name)
        return canonical(load_plant(name))
    except EngineError as problem:
        raise CommandError(str(problem)) from problem
    except (OSError, ValueError) as problem:
        raise CommandError(f"The plant file {name[:80]} cannot be read ({cause(problem)}).") from problem


def design_of(lesson: Lesson, plant: str | None, state: str | None, changes: Sequence[str]) -> Design:
    """The lesson's start, or a saved design, with knobs changed as KNOB=VALUE says. Raises CommandError."""
    if plant is not None and state is not None:
        raise CommandError("Give --plant or --state, not both: a saved design brings its own plant.")
    try:
        if plant is not None:
            lesson = fitted(lesson, plant_in(plant))
        design = lesson.start() if state is None else _state(state, lesson)
        lesson = fitted(find_lesson(lesson.id), design.plant)
        for change in changes:
            name, equals, words = change.partition("=")
            if not equals:
                raise CommandError(f"--set takes KNOB=VALUE; {change[:40]} has no equals sign.")
            design = lesson.apply(design, {name.strip(): lesson.knob(name.strip()).parse(words.strip())})
        return design
    except KnobError as problem:
        raise CommandError(str(problem)) from problem
    except (OverflowError, RecursionError) as problem:
        raise CommandError("The design holds a number or a nesting too large for a computer; simplify it.") from problem


def outcome_of(lesson: Lesson, design: Design, final: bool) -> Outcome:
    """What a design leads to; the lesson's long computation too if `final`. Raises what the lesson raises."""
    outcome = lesson.compute(design)
    if final and lesson.job is not None:
        for _, better in lesson.job.outcomes(outcome):
            outcome = better
    return outcome


def _state(name: str, lesson: Lesson) -> Design:
    """The design in a state file, which must belong to the lesson."""
    try:
        _plain_file(name)
        text = Path(name).read_text(encoding="utf-8")
    except UnicodeDecodeError as problem:
        raise CommandError(f"The state file {name[:80]} is not text; give one that the app saved.") from problem
    except (OSError, ValueError) as problem:
        raise CommandError(f"The state file {name[:80]} cannot be read ({cause(problem)}).") from problem
    design = read_design(text, LESSONS)
    if design.lesson != lesson.id:
        raise CommandError(f"The state file {name[:80]} belongs to lesson {design.lesson}, not {lesson.id}.")
    return design


def _plain_file(name: str) -> None:
    """Raises ValueError for what would be read for ever or fill the memory: a device, a pipe, a huge file."""
    path = Path(name)
    if path.exists() and not path.is_file():
        raise ValueError("it is no plain file")
    if path.exists() and path.stat().st_size > LARGEST:
        raise ValueError(f"it is larger than {LARGEST // 1_000_000} MB")
