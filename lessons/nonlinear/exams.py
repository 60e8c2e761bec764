"""The exams of lesson 14."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _sigma(lot: Lot) -> ExamItem:
    """The mean of a x² that sigma points find, a (m² + P)."""
    a, m, P = lot.whole(2, 5), lot.whole(1, 7), lot.part(1, 12, 4)
    return ExamItem({"a": float(a), "m": float(m), "P": P}, a * (m * m + P))


EXAMS = (
    Exam("sigma", decimals(2), _sigma),
)
