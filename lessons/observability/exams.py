"""Define the exams of lesson 3."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _start(lot: SeededDraws) -> ExamItem:
    """A = [a b; c d], C = [1 0], y(0) and ẏ(0) given: x₂(0) = (ẏ(0) − a y(0))/b."""
    a, b, c, d = lot.whole(-4, 4), lot.one((-5, -4, -2, 2, 4, 5)), lot.whole(-4, 4), lot.whole(-4, 4)
    y, x2 = lot.whole(1, 5), lot.part(-12, 12, 2)
    dy = a * y + b * x2
    return ExamItem({"A": np.array([[a, b], [c, d]], float), "y": float(y), "dy": dy}, x2, {"a": float(a), "b": float(b)})


def _blind(lot: SeededDraws) -> ExamItem | None:
    """A with whole eigenvalues; the mode at λ is hidden where 1 + c v₂ = 0, v₂ = (λ − a₁₁)/a₁₂."""
    hidden, other = lot.some(range(-8, 0), 2)
    a, b = lot.whole(-7, 3), lot.one((-4, -3, -2, 2, 3, 4))
    c = (a * (hidden + other - a) - hidden * other) / b  # trace and determinant from the two eigenvalues
    if a in (hidden, other) or c != int(c):
        return None
    A = np.array([[a, b], [c, hidden + other - a]], float)
    return ExamItem({"A": A, "hidden": float(hidden)}, b / (a - hidden), {"a11": float(a), "a12": float(b), "v2": (hidden - a) / b})


def _stroboscope(lot: SeededDraws) -> ExamItem:
    """Sampled at half its period a swing shows no velocity: h = π/ω."""
    m, k = lot.part(2, 30), float(lot.whole(2, 60) * 5)
    omega = math.sqrt(k / m)
    return ExamItem({"m": m, "k": k}, 1000 * math.pi / omega, {"omega": omega, "h": math.pi / omega})


def _energy(lot: SeededDraws) -> ExamItem | None:
    """∫ y² = x₀² c² (1 − e^{−2aT})/(2a)."""
    a, c, x0, T = lot.part(2, 20), float(lot.whole(2, 6)), float(lot.whole(2, 6)), lot.part(5, 20)
    W = c * c * (1 - math.exp(-2 * a * T)) / (2 * a)
    return ExamItem({"a": a, "c": c, "x0": x0, "T": T}, W * x0 * x0, {"W": W}) if a != 1 else None


EXAMS = (
    Exam("start", decimals(1), _start),
    Exam("blind", decimals(2), _blind),
    Exam("stroboscope", significant(3), _stroboscope),
    Exam("energy", significant(3), _energy),
)
