"""Define the exams of lesson 12."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _bound(lot: SeededDraws) -> ExamItem:
    """g s/(s² + c s + k) is cut away: both its Hankel values are g/(2c), so the bound with equal values counted once is 2σ = g/c."""
    g, c, k = float(lot.whole(2, 12)), lot.one((0.2, 0.4, 0.5, 0.8, 1.6, 2.5)), float(lot.whole(20, 89))
    return ExamItem({"g": g, "c": c, "k": k}, g / c, {"sigma": g / (2 * c)})


def _balance(lot: SeededDraws) -> ExamItem | None:
    """b²/(2a T²) = c² T²/(2a) at T = √(b/c)."""
    a, b, c = (lot.part(2, 60) for _ in range(3))
    return ExamItem({"a": a, "b": b, "c": c}, math.sqrt(b / c)) if b != c and 1 not in (a, b, c) else None


def _slow(lot: SeededDraws) -> ExamItem | None:
    """The second state at rest: the pole a₁₁ − a₁₂ a₂₁/a₂₂."""
    a11, a12, a21, a22 = -float(lot.whole(1, 6)), float(lot.whole(-6, 6)), float(lot.whole(-6, 6)), -float(lot.whole(21, 60))
    left = {"a11": a11, "a12": a12, "a21": a21, "a22": a22}
    pole = a11 - a12 * a21 / a22
    return ExamItem({"A": np.array([[a11, a12], [a21, a22]])}, pole, left) if abs(a12 * a21) > 4 and pole < -0.2 else None


def _tail(lot: SeededDraws) -> ExamItem:
    """2 Σ_{i>r} s q^{i−1} = 2 s q^r/(1 − q)."""
    s, q, r = float(lot.whole(3, 30)), lot.part(2, 8), float(lot.whole(3, 6))
    return ExamItem({"s": s, "q": q, "r": r}, 2 * s * q**r / (1 - q), {"power": q**r})


EXAMS = (
    Exam("bound", significant(3), _bound),
    Exam("balance", decimals(2), _balance),
    Exam("slow", decimals(3), _slow),
    Exam("tail", significant(3), _tail),
)
