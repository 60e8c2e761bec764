"""Define the exams of lesson 2."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals


def _double(lot: SeededDraws) -> ExamItem:
    """A block m = 1 with other b and k, both observer poles at p: l₂ = p² − k − b l₁ with l₁ = −2p − b."""
    b, k, p = lot.part(1, 9), float(lot.whole(1, 6)), -float(lot.whole(2, 6))
    first = -2 * p - b
    return ExamItem({"b": b, "k": k, "p": p}, p**2 - k - b * first, {"first": first})


def _decay(lot: SeededDraws) -> ExamItem | None:
    """A complex pair of A − LC has the real part −(l₁ + b)/2."""
    b, k = lot.part(1, 9), float(lot.whole(1, 6))
    l1, l2, N = lot.part(2, 30), float(lot.whole(1, 9)), lot.one((10.0, 20.0, 50.0, 100.0, 1000.0))
    sigma = (l1 + b) / 2
    if k + l2 + b * l1 <= 1.2 * sigma**2:
        return None
    return ExamItem({"b": b, "k": k, "L": np.array([[l1], [l2]]), "N": N}, math.log(N) / sigma, {"l1": l1, "sigma": sigma})


def _push(lot: SeededDraws) -> ExamItem:
    """ė = (A − LC) e + (0, d) rests at e₁ = d/(p₁ p₂), e₂ = l₁ e₁."""
    b, k, d = lot.part(1, 9), float(lot.whole(1, 6)), float(lot.whole(2, 9))
    p, r = (-float(v) for v in lot.some(range(2, 9), 2))
    l1 = -p - r - b
    return ExamItem({"b": b, "k": k, "p": p, "r": r, "d": d}, l1 * d / (p * r), {"l1": l1, "e1": d / (p * r)})


def _direct(lot: SeededDraws) -> ExamItem:
    """y = A₂ x + u, ŷ without u: at rest C e + u = u/(1 − l₂) and e₁ = −(b l₁ + l₂)(C e + u)/k. Stable for l₂ < 1, k l₁ < b (1 − l₂)."""
    b, k, u = lot.part(1, 9), float(lot.whole(1, 6)), float(lot.whole(2, 9))
    l1, l2 = -lot.part(5, 30), -float(lot.whole(1, 7))
    seen = u / (1 - l2)
    return ExamItem({"b": b, "k": k, "u": u, "L": np.array([[l1], [l2]])}, -(b * l1 + l2) / k * seen, {"l1": l1, "l2": l2, "seen": seen})


EXAMS = (
    Exam("double", decimals(2), _double),
    Exam("decay", decimals(2), _decay),
    Exam("push", decimals(2), _push),
    Exam("direct", decimals(2), _direct),
)
