"""Make the lesson of a live page: knobs and poles of a design beside the running plant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ..course.exercises.derivation import no_numbers
from ..course.figures.records import Figure
from ..course.lesson import Design, Lesson, Outcome
from ..course.scenes import NO_PATH
from ..text import NO_WORDS, text
from .desk import LiveDesk
from .rows import Rows

__all__ = ["live_lesson"]

QUESTION = text("What does this observer estimate while the plant runs?")
INTRODUCTION = text("The solid body stands where the readings are; states that nothing measures are those of the estimate. The ghost is "
                    "the estimate. Knobs and poles change the observer while it runs.")


def live_lesson(lesson: Lesson[Any], design: Design, desk: LiveDesk) -> Lesson[Any]:
    """The lesson with this design as its start; its figures are the strips of the desk."""
    def compute(changed: Design) -> Outcome[Any]:
        found = lesson.compute(changed)
        return replace(found, words=NO_WORDS, metrics={}, checks=())

    def figures(_: Outcome[Any]) -> Sequence[Figure]:
        return Rows().figures(desk.observer.routine)

    words = {language: replace(prose, question=QUESTION(language), introduction=INTRODUCTION(language), options=(), refutations=(),
                               steps=(), derivation=(), again=None, scenes={}, source="", references=())
             for language, prose in lesson.words.items()}
    knobs = tuple(replace(knob, default=design[knob.name]) for knob in lesson.knobs)
    told = replace(lesson, number=1, knobs=knobs, compute=compute, figures=figures, words=words, live=desk)
    return replace(told, tasks=(), exams=(), answering="", kick=False, job=None, seeds=None, pick=None, adapt=None, origin=None, code=None,
                   device=None, derived=no_numbers, again=None, path=NO_PATH, questions={}, estimates=None, take_record=None)
