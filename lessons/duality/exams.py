"""Define the exams of lesson 5."""

from __future__ import annotations

import numpy as np

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals


def _gain(lot: SeededDraws) -> ExamItem:
    """Spring-damper with m = 1: a feedback for (Aᵀ, Cᵀ) with poles p, q is given; what is the second entry of L?"""
    b, k = lot.part(1, 8, 4), float(lot.whole(1, 6))
    p, q = (-float(v) for v in lot.some(range(2, 9), 2))
    first = -p - q - b
    return ExamItem({"b": b, "k": k, "p": p, "q": q, "first": first}, p * q - k - b * first)


def _predictor(lot: SeededDraws) -> ExamItem:
    """L = a M with the filter's gain M = P⁻ c/(c² P⁻ + R)."""
    a, c, P, R = lot.part(11, 25), float(lot.whole(2, 5)), lot.part(2, 19), float(lot.whole(2, 9))
    M = P * c / (c * c * P + R)
    return ExamItem({"a": a, "c": c, "P": P, "R": R}, a * M, {"M": M})


def _adjoint(lot: SeededDraws) -> ExamItem | None:
    """λᵀx stays: λ₂ = (λ(0)ᵀx(0) − λ₁ x₁)/x₂."""
    a, b, c, d, u, first = (lot.whole(-6, 6) for _ in range(6))
    v = lot.one((-5, -4, -2, 2, 4, 5))
    inner = a * c + b * d
    if 0 in (a, b, c, d, u, first, inner):
        return None
    return ExamItem({"x0": np.array([[a], [b]], float), "l0": np.array([[c], [d]], float), "x1": np.array([[u], [v]], float),
                     "first": float(first)}, (inner - first * u) / v, {"inner": float(inner), "u": float(u), "v": float(v)})


def _locus(lot: SeededDraws) -> ExamItem:
    """s² = a ± j√(q/r): the LQR poles of p̈ = a p + u lie (a² + q/r)^¼ from the origin."""
    a, q, r = float(lot.whole(2, 9)), float(lot.whole(2, 40)), float(lot.whole(2, 5))
    square = a * a + q / r
    return ExamItem({"a": a, "q": q, "r": r}, square**0.25, {"square": square})


EXAMS = (
    Exam("gain", decimals(2), _gain),
    Exam("locus", decimals(2), _locus),
    Exam("predictor", decimals(3), _predictor),
    Exam("adjoint", decimals(2), _adjoint),
)
