"""The exams of lesson 17."""

from __future__ import annotations

import numpy as np

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _zero(lot: Lot) -> ExamItem:
    """The zero of (A, E, C) for two states, the first one measured: s = d − b e₂/e₁."""
    a, b, c, d = -lot.whole(1, 4), lot.whole(1, 4), -lot.whole(1, 4), -lot.whole(1, 6)
    e1, e2 = lot.whole(1, 4), lot.one((-1, 1)) * lot.whole(1, 5)
    return ExamItem({"A": np.array([[a, b], [c, d]], float), "E": np.array([[e1], [e2]], float)}, d - b * e2 / e1,
                    {"b": float(b), "d": float(d), "e1": float(e1), "e2": float(e2)})


EXAMS = (
    Exam("zero", decimals(2), _zero),
)
