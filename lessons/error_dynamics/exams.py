"""The exams of lesson 2."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _double(lot: Lot) -> ExamItem:
    """A block m = 1 with other b and k, both observer poles at −p: l₂ = p² − k − b l₁ with l₁ = 2p − b."""
    b, k, p = lot.part(1, 9), float(lot.whole(1, 6)), float(lot.whole(2, 6))
    first = 2 * p - b
    return ExamItem({"b": b, "k": k, "p": p}, p**2 - k - b * first, {"first": first})


EXAMS = (
    Exam("double", decimals(2), _double),
)
