"""Define the exams of lesson 18."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _loss(lot: SeededDraws) -> ExamItem:
    """ẋ = s x + u sampled every h: 100 e^{−2 s h} per cent may be lost."""
    s, h = lot.part(2, 12, 2), lot.whole(2, 10) * 10.0
    return ExamItem({"s": s, "h": h}, 100 * math.exp(-2 * s * h / 1000), {"twice": 2 * s * h / 1000})


def _gap(lot: SeededDraws) -> ExamItem:
    """Three predictions: P⁺ = a² P + Q."""
    a, Q, p = lot.part(11, 20), float(lot.whole(2, 9)), lot.part(2, 30)
    first = a * a * p + Q
    second = a * a * first + Q
    return ExamItem({"a": a, "Q": Q, "p": p}, a * a * second + Q, {"P1": first, "P2": second})


def _burst(lot: SeededDraws) -> ExamItem:
    """A burst goes on with r < 1/a², so it has fewer than a²/(a² − 1) packets in the mean."""
    a = lot.part(105, 230, 100)
    return ExamItem({"a": a}, a * a / (a * a - 1), {"r": 1 / (a * a)})


def _late(lot: SeededDraws) -> ExamItem | None:
    """z² − λ z + g K has a product of one at K = s/(λ − 1), while λ < 2."""
    s, h = lot.part(2, 40), float(lot.whole(2, 30) * 10)
    lam = math.exp(s * h / 1000)
    if not 1.02 < lam < 1.9 or s == 1:
        return None
    return ExamItem({"s": s, "h": h}, s / (lam - 1), {"sh": s * h / 1000, "lam": lam, "g": (lam - 1) / s})


EXAMS = (
    Exam("loss", decimals(1), _loss),
    Exam("gap", decimals(2), _gap),
    Exam("burst", decimals(2), _burst),
    Exam("late", significant(3), _late),
)
