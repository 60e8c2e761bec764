"""Define the exams of lesson 8."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant

SMALL_INTENSITIES = (0.1, 0.2, 0.5, 2.0)


def _least(lot: SeededDraws) -> ExamItem:
    """ẋ = −a x + w, y = x + v: the Kalman gain L = −a + √(a² + W/V)."""
    a, W, V = float(lot.whole(2, 7)), float(lot.whole(2, 39)), lot.one((*SMALL_INTENSITIES, 1.0))
    return ExamItem({"a": a, "W": W, "V": V}, -a + math.sqrt(a * a + W / V))


def _valley(lot: SeededDraws) -> ExamItem:
    """The variance at any L: P = (W + L² V)/(2 (a + L))."""
    a, W, V, L = float(lot.whole(2, 7)), float(lot.whole(2, 30)), lot.one(SMALL_INTENSITIES), float(lot.whole(2, 12))
    return ExamItem({"a": a, "W": W, "V": V, "L": L}, (W + L * L * V) / (2 * (a + L)))


def _force(lot: SeededDraws) -> ExamItem | None:
    """ẋ = u + w, y = x + v, u = −K x̂: the largest L at which K e has the deviation s at most, from P(L) = (W + L² V)/(2 L)."""
    W, V, K = float(lot.whole(2, 20)), lot.one(SMALL_INTENSITIES), float(lot.whole(2, 8))
    s = round(K * math.sqrt(lot.one((1.3, 1.6, 2.0)) * math.sqrt(W * V)), 1)
    most = s * s / (K * K)
    inside = most**2 - W * V
    return ExamItem({"W": W, "V": V, "K": K, "s": s}, (most + math.sqrt(inside)) / V, {"most": most}) if inside > 0.2 * W * V else None


def _samples(lot: SeededDraws) -> ExamItem:
    """Readings of deviation σ at a rate f are an intensity σ²/f; without damping L = √(W/V)."""
    W, f, sigma = float(lot.whole(2, 30)), float(lot.whole(2, 20) * 5), lot.part(2, 30)
    V = sigma**2 / f
    return ExamItem({"W": W, "f": f, "sigma": sigma}, math.sqrt(W / V), {"V": V})


EXAMS = (
    Exam("least", decimals(2), _least),
    Exam("valley", decimals(2), _valley),
    Exam("force", significant(3), _force),
    Exam("samples", significant(3), _samples),
)
