"""Define the exams of lesson 11."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _diophantine(lot: SeededDraws) -> ExamItem:
    """A = s − a, B = k, Φ = (s + c)²: E = s + a + 2c and F = (c² + a e)/k."""
    a, c, k = float(lot.whole(1, 5)), float(lot.whole(2, 8)), float(lot.whole(2, 5))
    e = 2 * c + a
    return ExamItem({"a": a, "c": c, "k": k}, (c * c + a * e) / k, {"e": e})


def _coils(lot: SeededDraws) -> ExamItem:
    """u_l + u_r = F, l (u_r − u_l) = M."""
    l, F, M = lot.part(2, 8), float(lot.whole(-12, 12)), lot.part(2, 30)
    return ExamItem({"l": l, "F": F, "M": M}, F / 2 + M / (2 * l))


def _mixing(lot: SeededDraws) -> ExamItem | None:
    """b = −g₁₂/g₁₁ leaves g₂₂ + g₂₁ b, the determinant over g₁₁."""
    g11, g12, g21, g22 = float(lot.whole(2, 8)), float(lot.whole(-5, 5)), float(lot.whole(-5, 5)), float(lot.whole(2, 9))
    if g12 * g21 == 0 or abs(g12 * g21) > g11 * g22:
        return None
    left = {"g11": g11, "g12": g12, "g21": g21, "g22": g22, "b": -g12 / g11}
    return ExamItem({"G": np.array([[g11, g12], [g21, g22]])}, g22 - g21 * g12 / g11, left)


def _damping(lot: SeededDraws) -> ExamItem | None:
    """(d + g)/(2 √(m k)) = ζ."""
    m, k, d = float(lot.whole(5, 20)), float(lot.whole(5, 60) * 10), float(lot.whole(2, 20))
    zeta = lot.one((0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8))
    g = 2 * zeta * math.sqrt(m * k) - d
    return ExamItem({"m": m, "k": k, "d": d, "zeta": zeta}, g) if g > 2 else None


EXAMS = (
    Exam("diophantine", significant(3), _diophantine),
    Exam("coils", decimals(2), _coils),
    Exam("mixing", decimals(2), _mixing),
    Exam("damping", significant(3), _damping),
)
