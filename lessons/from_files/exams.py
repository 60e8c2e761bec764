"""Read the exams of a lesson file: drawn numbers, and an answer as a formula."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any  # the value of a knob is `Any` until the knob has checked it

from observer_lab.course.exercises.derivation import PLACE
from observer_lab.course.exercises.exam import WHOLE_NUMBER, Digits, Exam, ExamItem, SeededDraws, decimals, significant
from observer_lab.course.exercises.typed_answers import NoFiniteValue, UnreadableInput, evaluate_typed
from observer_lab.course.knobs import KnobError, Number
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import ExamWords
from observer_lab.course.reading.toml_table import Table, is_number, knob_named
from observer_lab.engine import EngineError
from observer_lab.text import text

EXAM_KEYS = ("id", "digits", "numbers", "steps", "set", "answer")
DIGITS = re.compile(r"whole|([0-9]) decimals?|([1-9]) significant")
TRIED_SEEDS = 3  # when the lesson is read
MOST_PARTS = 1000


def read_exams(top: Table, lesson: Lesson, words: Mapping[str, ExamWords]) -> tuple[Exam, ...]:
    """`[[exams]]`, each tried with a few seeds. Raises LessonFileError."""
    found = []
    for table in top.tables("exams"):
        exam, names = _exam(table.only(*EXAM_KEYS), lesson)
        if exam.id not in words:
            raise table.refuse("id", text("The words have no section “## exam {id}: title”.", id=exam.id))
        told = words[exam.id]
        for place in (*PLACE.findall(told.statement), *PLACE.findall(told.derivation)):
            if place not in names:
                raise table.refuse("id", text("The words of the exam {id} name [[{place}]], which is none of {names}.", id=exam.id,
                                              place=place, names=", ".join(names)))
        _try_out(table, exam)
        found.append(exam)
    return tuple(found)


def _exam(table: Table, lesson: Lesson) -> tuple[Exam, tuple[str, ...]]:
    """An exam and the names that its words may show."""
    numbers = {name: _draw(table.table("numbers"), name) for name in table.table("numbers").data}
    if not numbers:
        raise table.refuse("numbers", text("An exam needs numbers = {{ name = [low, high] }}, or each student gets the same."))
    steps = {name: table.table("steps").words(name) for name in table.table("steps").data}
    changes = {name: table.table("set").words(name) for name in table.table("set").data}
    for name in changes:
        if not isinstance(knob_named(table.table("set"), name, name, lesson.knobs), Number):
            raise table.table("set").refuse(name, text("{name} is no number that an exam can set.", name=name))
    draw = partial(_item, lesson, numbers, steps, changes, table.words("answer"))
    return Exam(table.words("id"), _digits(table), draw), (*numbers, *steps, "answer")


def _digits(table: Table) -> Digits:
    found = DIGITS.fullmatch(table.words("digits", "2 decimals"))
    if not found:
        raise table.refuse("digits", text("digits must be “whole”, “2 decimals” or “3 significant”."))
    return decimals(int(found[1])) if found[1] else significant(int(found[2])) if found[2] else WHOLE_NUMBER


def _draw(table: Table, name: str) -> Callable[[SeededDraws], float]:
    """[low, high] draws a whole number; [low, high, parts] one in halves, tenths or other parts."""
    value = table.data[name]
    whole = isinstance(value, list) and len(value) in (2, 3) and all(is_number(v) and v == int(v) for v in value)
    if not whole or value[0] > value[1] or (len(value) == 3 and not 1 <= value[2] <= MOST_PARTS):
        raise table.refuse(name, text("{name} must be [low, high] or [low, high, parts] of whole numbers, as [1, 9, 10] for tenths.",
                                      name=name))
    low, high, parts = (*map(int, value), 1)[:3]
    return lambda lot: lot.part(low * parts, high * parts, parts)


def _item(lesson: Lesson, numbers: Mapping[str, Callable[[SeededDraws], float]], steps: Mapping[str, str], changes: Mapping[str, str],
          answer: str, lot: SeededDraws) -> ExamItem | None:
    """One draw: the numbers, the steps in their order, the run's metrics where knobs are set, the answer; None where it has none."""
    given = {name: draw(lot) for name, draw in numbers.items()}
    letters: dict[str, Any] = dict(given)
    try:
        if changes:
            design = lesson.apply(lesson.start(), {name: evaluate_typed(formula, letters) for name, formula in changes.items()})
            letters = {**lesson.compute(design).metrics, **letters}
        found = {}
        for name, formula in steps.items():
            found[name] = letters[name] = evaluate_typed(formula, letters)
        return ExamItem(given, evaluate_typed(answer, letters), found)
    except (NoFiniteValue, KnobError, EngineError):
        return None


def _try_out(table: Table, exam: Exam) -> None:
    """Draw a few items. Raises LessonFileError where a formula cannot be read, or no draw is fit."""
    try:
        for seed in range(TRIED_SEEDS):
            exam.item(f"trial {seed}")
    except UnreadableInput as problem:
        raise table.refuse("answer", text("“{formula}” is no formula of the numbers, the steps and, after set, the metrics.",
                                          formula=str(problem)[:60])) from problem
    except RuntimeError as problem:
        raise table.refuse("answer", text("None of the numbers drawn for the exam {id} gives a fit answer; change ranges or digits.",
                                          id=exam.id)) from problem
