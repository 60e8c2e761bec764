"""The exams of lesson 1."""

from __future__ import annotations

import math

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _trust(lot: Lot) -> ExamItem:
    """A runaway chip with one state: e decays as e^{(a − L)t}; which L leaves a tenth of the error at time t?"""
    a, t = lot.part(2, 9), lot.part(2, 8, 2)
    return ExamItem({"a": a, "t": t}, a + math.log(10.0) / t, {"ln": math.log(10.0)})


EXAMS = (
    Exam("trust", decimals(2), _trust),
)
