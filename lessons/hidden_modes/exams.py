"""Define the exams of lesson 6."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.exercises.exam import WHOLE_NUMBER, Exam, ExamItem, SeededDraws, decimals


def _alike(a: float, b: float) -> np.ndarray:
    """Two equal halves that act on each other."""
    return np.array([[a, b], [b, a]], float)


def _bolted(lot: SeededDraws) -> ExamItem | None:
    """A = [a b; b a], C = [1 −1]: which eigenvalue of A − LC is the same for every L? The one of (1, 1): a + b."""
    a, b = -float(lot.whole(2, 9)), float(lot.whole(1, 12))
    return ExamItem({"A": _alike(a, b)}, a + b, {"a": a, "b": b})


def _cancel(lot: SeededDraws) -> ExamItem:
    """A companion matrix with the poles −p and −q: its eigenvector (1, −q) is hidden from (c, 1) where c = q."""
    p = lot.whole(2, 7)
    q = p + lot.whole(1, 12)
    return ExamItem({"b": float(p + q), "k": float(p * q)}, float(q), {"fast": -float(q)})


def _left(lot: SeededDraws) -> ExamItem | None:
    """C = [1 1] hides (1, −1), which decays with a − b: of e(0) the part (e₁ − e₂)/2 is left."""
    a, b = -float(lot.whole(2, 9)) / 10, float(lot.whole(1, 7)) / 10
    first, second, t = float(lot.whole(-9, 9)), float(lot.whole(-9, 9)), lot.part(2, 10, 2)
    part, rate = (first - second) / 2, a - b
    if abs(part) < 2 or first * second == 0:
        return None
    return ExamItem({"A": _alike(a, b), "e0": np.array([[first], [second]]), "t": t}, part * math.exp(rate * t),
                    {"first": first, "second": second, "part": part, "rate": rate})


def _draft(lot: SeededDraws) -> ExamItem | None:
    """Along the hidden direction L does not appear: e₁ = −d/(a + b)."""
    a, b, d = -float(lot.whole(4, 12)), float(lot.whole(1, 8)), float(lot.whole(2, 9))
    return ExamItem({"A": _alike(a, b), "d": d}, -d / (a + b), {"a": a, "b": b}) if a + b < 0 else None


EXAMS = (
    Exam("bolted", WHOLE_NUMBER, _bolted),
    Exam("cancel", WHOLE_NUMBER, _cancel),
    Exam("left", decimals(2), _left),
    Exam("draft", decimals(2), _draft),
)
