"""The exams of lesson 5."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _gain(lot: Lot) -> ExamItem:
    """Spring-damper with m = 1: a feedback for (Aᵀ, Cᵀ) with poles −p, −q is given; what is the second entry of L?"""
    b, k = lot.part(1, 8, 4), float(lot.whole(1, 6))
    p, q = map(float, lot.some(range(2, 9), 2))
    first = p + q - b
    return ExamItem({"b": b, "k": k, "p": -p, "q": -q, "first": first}, p * q - k - b * first)


EXAMS = (
    Exam("gain", decimals(2), _gain),
)
