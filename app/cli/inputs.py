"""Read what commands are given: lessons by name, plants and designs from files."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from observer_lab.lessons import all_lessons

from ..course.knobs import KnobError
from ..course.lectures import Lecture, read_lecture
from ..course.lesson import Design, Lesson
from ..engine import EngineError, load_plant
from ..plants.examples import EXAMPLES, example
from ..plants.own_plant import read_plant_file
from ..session.state.saved_state import TOO_LARGE, SavedState, read_state
from ..session.state.token import is_token, read_token
from ..text import read_outside_bytes
from .options import CommandError, error_cause

MAX_FILE_BYTES = 10_000_000  # bytes of a file that is read at all


def find_lesson(id: str, lessons: Mapping[str, Lesson] | None = None) -> Lesson:
    """The lesson of that id, of the course if no lessons are given. Raises CommandError naming those there are."""
    lessons = all_lessons() if lessons is None else lessons
    if id not in lessons:
        raise CommandError(f"There is no lesson {id[:40]}; there are {', '.join(lessons)}.")
    return lessons[id]


def fit_lesson(lesson: Lesson, plant: str) -> Lesson:
    """The lesson for that plant. Raises CommandError where the two do not fit."""
    try:
        return lesson.fit(plant)
    except (EngineError, KnobError) as problem:
        raise CommandError(str(problem)) from problem


def read_plant(name: str) -> str:
    """The canonical text of the plant in a file, or of an example of that name. Raises CommandError."""
    try:
        if name in EXAMPLES:
            return example(name)
        content = read_outside_bytes(Path(name), MAX_FILE_BYTES)
        load_plant(name)  # says what is wrong with the file before it is read whole
        return read_plant_file(Path(name).name, content)
    except EngineError as problem:
        raise CommandError(str(problem)) from problem
    except (OSError, ValueError) as problem:
        raise CommandError(f"The plant file {name[:200]} cannot be read ({error_cause(problem)}).") from problem


def read_design(lesson: Lesson, plant: str | None, state: str | None, changes: Sequence[str],
                lessons: Mapping[str, Lesson] | None = None) -> Design:
    """The lesson's start, or a saved design, with knobs changed as KNOB=VALUE says. Raises CommandError."""
    if plant is not None and state is not None:
        raise CommandError("Give --plant or --state, not both: a saved design brings its own plant.")
    try:
        if plant is not None:
            lesson = fit_lesson(lesson, read_plant(plant))
        design = lesson.start() if state is None else _design_in(state, lesson, lessons)
        lesson = fit_lesson(find_lesson(lesson.id, lessons), design.plant)
        return changed(lesson, design, changes)
    except KnobError as problem:
        raise CommandError(str(problem)) from problem
    except (OverflowError, RecursionError) as problem:
        raise CommandError(str(TOO_LARGE)) from problem


def changed(lesson: Lesson, design: Design, changes: Sequence[str]) -> Design:
    """The design with knobs changed as KNOB=VALUE says. Raises CommandError."""
    try:
        for change in changes:
            name, equals, words = change.partition("=")
            if not equals:
                raise CommandError(f"--set takes KNOB=VALUE; {change[:40]} has no equals sign.")
            design = lesson.apply(design, {name.strip(): lesson.knob(name.strip()).parse(words.strip())})
        return design
    except KnobError as problem:
        raise CommandError(str(problem)) from problem


def read_saved_state(state: str, lessons: Mapping[str, Lesson] | None = None) -> SavedState:
    """The state of a token, of a link that ends in one, or in a file that holds either or was saved. Raises CommandError.

    What could not be taken over is said on stderr.
    """
    saved = _read(state, lessons)
    for note in saved.notes:
        print(f"observer-lab: {note}", file=sys.stderr)
    return saved


def read_lecture_file(name: str, lessons: Mapping[str, Lesson]) -> Lecture:
    """The lecture of a TOML file about these lessons. Raises CommandError."""
    try:
        return read_lecture(read_text(name, "lecture", "give a TOML file"), lessons)
    except KnobError as problem:
        raise CommandError(str(problem)) from problem


def read_view(state: str | None, language: str | None, lessons: Mapping[str, Lesson] | None = None) -> SavedState:
    """How a state was shown, with the language that was asked for instead, if any; without a state as a page opens. Raises CommandError."""
    saved = SavedState(Design("", ())) if state is None else replace(_read(state, lessons), notes=())
    return saved if language is None else replace(saved, language=language)


def _read(state: str, lessons: Mapping[str, Lesson] | None) -> SavedState:
    known = all_lessons() if lessons is None else lessons
    words = state if is_token(state) else read_text(state, "state", "give a token, a link or a file that the app saved")
    try:
        return read_token(words, known) if is_token(words) else read_state(words, known)
    except KnobError as problem:
        raise CommandError(str(problem)) from problem


def _design_in(state: str, lesson: Lesson, lessons: Mapping[str, Lesson] | None) -> Design:
    """The design of a state, which must belong to the lesson."""
    design = read_saved_state(state, lessons).design
    if design.lesson != lesson.id:
        raise CommandError(f"The state {state[:80]} belongs to lesson {design.lesson}, not {lesson.id}.")
    return design


def read_text(name: str, what: str, instead: str) -> str:
    """What a text file holds. Raises CommandError, which says what to give instead."""
    try:
        return read_outside_bytes(Path(name), MAX_FILE_BYTES).decode("utf-8")
    except UnicodeDecodeError as problem:
        raise CommandError(f"The {what} file {name[:80]} is not text; {instead}.") from problem
    except (OSError, ValueError) as problem:
        raise CommandError(f"The {what} file {name[:80]} cannot be read ({error_cause(problem)}); {instead}.") from problem
