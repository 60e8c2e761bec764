"""The exams of lesson 18."""

from __future__ import annotations

import math

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _loss(lot: Lot) -> ExamItem:
    """ẋ = s x + u sampled every h: 100 e^{−2 s h} per cent may be lost."""
    s, h = lot.part(2, 12, 2), lot.whole(2, 10) * 10.0
    return ExamItem({"s": s, "h": h}, 100 * math.exp(-2 * s * h / 1000), {"twice": 2 * s * h / 1000})


EXAMS = (
    Exam("loss", decimals(1), _loss),
)
