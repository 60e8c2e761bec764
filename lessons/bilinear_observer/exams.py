"""The exams of lesson 16."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _pole(lot: Lot) -> ExamItem:
    """Scalar A*, B* and a pole p: π = (A* − p)/B*."""
    a, b, p = -lot.part(10, 89), lot.part(11, 48), -float(lot.whole(12, 44))
    return ExamItem({"a": a, "b": b, "p": p}, (a - p) / b)


EXAMS = (
    Exam("pole", decimals(2), _pole),
)
