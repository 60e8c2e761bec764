"""The exams of lesson 19."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _silent(lot: Lot) -> ExamItem:
    """A = [a 1; 0 b], C = [1 c]: the mode at b has the direction (1, b − a) and is hidden where 1 + c (b − a) = 0."""
    a, b = lot.some(range(-9, 0), 2)
    return ExamItem({"a": float(a), "b": float(b)}, 1.0 / (a - b), {"gap": float(b - a)})


EXAMS = (
    Exam("silent", decimals(2), _silent),
)
