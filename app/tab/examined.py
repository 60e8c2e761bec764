"""What a person can ask about exams; a field of type `object` holds what a browser sent, as in `commands`."""

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
class Withhold:
    """Whether answers are noted and nothing is told of them."""

    on: object


Examining = AnswerExam | AnotherVariant | SetKey | Withhold
