"""The exams of lesson 8."""

from __future__ import annotations

import math

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _least(lot: Lot) -> ExamItem:
    """ẋ = −a x + w, y = x + v: the Kalman gain L = −a + √(a² + W/V)."""
    a, W, V = lot.whole(1, 6), lot.whole(2, 39), lot.one((0.1, 0.2, 0.5, 1.0, 2.0))
    return ExamItem({"a": float(a), "W": float(W), "V": V}, -a + math.sqrt(a * a + W / V), {"ratio": W / V})


EXAMS = (
    Exam("least", decimals(2), _least),
)
