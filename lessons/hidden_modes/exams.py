"""The exams of lesson 6."""

from __future__ import annotations

from app.lesson.exam import WHOLE, Exam, ExamItem, Lot


def _bolted(lot: Lot) -> ExamItem | None:
    """A = [a b; b a], C = [1 −1]: which eigenvalue of A − LC is the same for every L? The one of (1, 1): a + b."""
    a, b = -lot.whole(2, 8), lot.whole(1, 11)
    return ExamItem({"a": float(a), "b": float(b)}, float(a + b)) if a + b else None


EXAMS = (
    Exam("bolted", WHOLE, _bolted),
)
