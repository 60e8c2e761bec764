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


def _geophone(lot: SeededDraws) -> ExamItem | None:
    """(m s² + k)(s² + 2ζω s + ω²) + g s³ has the roots ±jω at g = 2ζ(k/ω − m ω)."""
    m, k = float(lot.whole(5, 20)), float(lot.whole(20, 120) * 10)
    corner, zeta = float(lot.one((0.05, 0.08, 0.1, 0.15, 0.2, 0.25, 0.3))), float(lot.one((0.6, 0.65, 0.7, 0.75, 0.8)))
    omega = 2 * math.pi * corner
    g = 2 * zeta * (k / omega - m * omega)
    return ExamItem({"m": m, "k": k, "corner": corner, "zeta": zeta}, g, {"omega": omega}) if g > 50 else None


def _mixing(lot: SeededDraws) -> ExamItem | None:
    """b = −g₁₂/g₁₁ leaves g₂₂ + g₂₁ b, the determinant over g₁₁."""
    g11, g12, g21, g22 = float(lot.whole(2, 8)), float(lot.whole(-5, 5)), float(lot.whole(-5, 5)), float(lot.whole(2, 9))
    if g12 * g21 == 0 or abs(g12 * g21) > g11 * g22:
        return None
    left = {"g11": g11, "g12": g12, "g21": g21, "g22": g22, "b": -g12 / g11}
    return ExamItem({"G": np.array([[g11, g12], [g21, g22]])}, g22 - g21 * g12 / g11, left)


def _tilt(lot: SeededDraws) -> ExamItem:
    """ω² x = g θ."""
    x, theta = float(lot.whole(2, 60)), float(lot.part(2, 90))
    omega = math.sqrt(9.81 * theta / x)
    return ExamItem({"x": x, "theta": theta}, omega / (2 * math.pi), {"omega": omega})


EXAMS = (
    Exam("diophantine", significant(3), _diophantine),
    Exam("geophone", significant(3), _geophone),
    Exam("mixing", decimals(2), _mixing),
    Exam("tilt", significant(3), _tilt),
)
