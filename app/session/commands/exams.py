"""Define the commands about exams."""

from __future__ import annotations

from ...course.handin.course_file import Kind
from ...course.handin.learner import Report
from .commands import Command, Notice


class AnswerExam(Command, frozen=True):
    """An answer to an exam, as it was typed."""

    exam: str
    said: object


class AnotherVariant(Command, frozen=True):
    """Other numbers for an exam."""

    exam: str


class SetKey(Command, frozen=True):
    """The student's key, from which the numbers of all exams are drawn."""

    key: object


class SetWord(Command, frozen=True):
    """The word that belongs to the student's key in this course."""

    word: object


class WithholdResults(Command, frozen=True):
    """Whether answers are noted and nothing is told of them."""

    on: object


class HandIn(Command, frozen=True):
    """Sign an answer to an exam, or a solved task, as a hand-in; `said` is the answer as it was typed."""

    kind: Kind
    item: str
    said: object = ""


class SaveHandIn(Command, frozen=True):
    """Give the person the last hand-in of an item as a file; `item` is its name in the course."""

    item: str


class HandInReported(Notice, frozen=True):
    """A hand-in has gone to the learning platform, or it is known why not."""

    report: Report
