"""Define the commands about exams."""

from __future__ import annotations

from dataclasses import dataclass

from ...course.handin.course_file import Kind
from ...course.handin.learner import Report


@dataclass(frozen=True)
class AnswerExam:
    """An answer to an exam, as it was typed."""

    exam: str
    said: object


@dataclass(frozen=True)
class AnotherVariant:
    """Other numbers for an exam."""

    exam: str


@dataclass(frozen=True)
class SetKey:
    """The student's key, from which the numbers of all exams are drawn."""

    key: object


@dataclass(frozen=True)
class WithholdResults:
    """Whether answers are noted and nothing is told of them."""

    on: object


@dataclass(frozen=True)
class HandIn:
    """Sign an answer to an exam, or a solved task, as a hand-in; `said` is the answer as it was typed."""

    kind: Kind
    item: str
    said: object = ""


@dataclass(frozen=True)
class SaveHandIn:
    """Give the person the last hand-in of an item as a file; `item` is its name in the course."""

    item: str


@dataclass(frozen=True)
class HandInReported:
    """A hand-in has gone to the learning platform, or it is known why not."""

    report: Report


Answering = AnswerExam | AnotherVariant | SetKey | WithholdResults
HandingIn = HandIn | SaveHandIn | HandInReported
Examining = Answering | HandingIn
