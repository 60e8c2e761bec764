"""The exams of lesson 3."""

from __future__ import annotations

import numpy as np

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _start(lot: Lot) -> ExamItem:
    """A = [a b; c d], C = [1 0], y(0) and ẏ(0) given: x₂(0) = (ẏ(0) − a y(0))/b."""
    a, b, c, d = lot.whole(-4, 4), lot.one((-5, -4, -2, 2, 4, 5)), lot.whole(-4, 4), lot.whole(-4, 4)
    y, x2 = lot.whole(1, 5), lot.part(-12, 12, 2)
    dy = a * y + b * x2
    return ExamItem({"A": np.array([[a, b], [c, d]], float), "a": float(a), "b": float(b), "y": float(y), "dy": dy}, x2)


EXAMS = (
    Exam("start", decimals(1), _start),
)
