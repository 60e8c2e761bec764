"""The exams of lesson 12."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, significant


def _bound(lot: Lot) -> ExamItem:
    """g s/(s² + c s + k) is cut away: both its Hankel values are g/(2c), so the bound 2Σσ is 2g/c."""
    g, c, k = float(lot.whole(1, 9)), lot.one((0.2, 0.4, 0.5, 0.8, 1.6, 2.5)), float(lot.whole(20, 89))
    return ExamItem({"g": g, "c": c, "k": k}, 2 * g / c, {"sigma": g / (2 * c)})


EXAMS = (
    Exam("bound", significant(3), _bound),
)
