"""The exams of lesson 15."""

from __future__ import annotations

from app.lesson.exam import WHOLE, Exam, ExamItem, Lot


def _criterion(lot: Lot) -> ExamItem:
    """J of example 1 at an integer s with integer weights: 2α|s| + β|s² + 4s + 3| + γ|50 + 30s|."""
    s, a, b, c = -lot.whole(2, 9), lot.whole(1, 4), lot.whole(1, 4), lot.whole(1, 4)
    answer = 2 * a * abs(s) + b * abs(s * s + 4 * s + 3) + c * abs(50 + 30 * s)
    return ExamItem({"s": float(s), "a": float(a), "b": float(b), "c": float(c)}, float(answer))


EXAMS = (
    Exam("criterion", WHOLE, _criterion),
)
