"""Define the commands about exams."""

from __future__ import annotations

from dataclasses import dataclass


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


Examining = AnswerExam | AnotherVariant | SetKey | WithholdResults
