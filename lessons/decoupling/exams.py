"""The exams of lesson 11."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, significant


def _diophantine(lot: Lot) -> ExamItem:
    """A = s − a, B = k, Φ = (s + c)²: E = s + a + 2c and F = (c + a)²/k."""
    a, c, k = lot.whole(1, 5), lot.whole(2, 8), lot.whole(2, 5)
    return ExamItem({"a": float(a), "c": float(c), "k": float(k)}, (c + a) ** 2 / k, {"sum": float(a + c)})


EXAMS = (
    Exam("diophantine", significant(3), _diophantine),
)
