"""The exams of lesson 10."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, significant


def _doyle(lot: Lot) -> ExamItem:
    """By how many per cent may the input's gain exceed the model's: 100/(d f), f = 2 + √(4 + q) and d = 2 + √(4 + σ)."""
    root_q, root_s = lot.whole(3, 12), lot.whole(3, 12)
    f, d = 2.0 + root_q, 2.0 + root_s
    return ExamItem({"q": root_q**2 - 4.0, "sigma": root_s**2 - 4.0}, 100 / (d * f), {"f": f, "d": d})


EXAMS = (
    Exam("doyle", significant(3), _doyle),
)
