"""Define the exams of lesson 1."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals


def _jump(lot: SeededDraws) -> ExamItem:
    """The reduced-order observer x̂₁ = w + ℓ y with the pole p = a₁₁ − ℓ a₂₁: a reading that is v too high moves x̂₁ by ℓ v."""
    a, b, c = float(lot.whole(1, 4)), float(lot.whole(2, 6)), float(lot.whole(1, 4))
    A = np.array([[-a, a], [b, -b - c]])
    p, v = -float(lot.whole(6, 15)), lot.part(2, 9)
    gain = (-a - p) / b
    return ExamItem({"A": A, "p": p, "v": v}, gain * v, {"a11": -a, "a21": b, "gain": gain})


def _copy(lot: SeededDraws) -> ExamItem:
    """e(t) = e(0) e^{−at}: t = ln(e(0)/e(t))/a."""
    a, e0, e1 = lot.part(1, 9), float(lot.whole(10, 40)), lot.one((0.1, 0.2, 0.5, 2.0, 5.0))
    return ExamItem({"a": a, "e0": e0, "e1": e1}, math.log(e0 / e1) / a)


def _bias(lot: SeededDraws) -> ExamItem | None:
    """ė = −(a + L) e + q − q̂ rests at (q − q̂)/(a + L)."""
    a, L, q, believed = lot.part(2, 9), float(lot.whole(2, 9)), float(lot.whole(4, 30)), float(lot.whole(4, 30))
    return ExamItem({"a": a, "q": q, "qhat": believed, "L": L}, (q - believed) / (a + L)) if abs(q - believed) > 2 else None


def _core(lot: SeededDraws) -> ExamItem:
    """Two temperatures, the case measured: l₂ from the trace of A − LC, l₁ from its determinant."""
    a, b, c = float(lot.whole(1, 4)), float(lot.whole(1, 5)), float(lot.whole(1, 4))
    A = np.array([[-a, a], [b, -b - c]])
    p, r = (-float(v) for v in sorted(lot.some(range(3, 12), 2)))
    l2 = float(np.trace(A)) - (p + r)
    left = {f"a{i + 1}{j + 1}": float(A[i, j]) for i in range(2) for j in range(2)}
    return ExamItem({"A": A, "p": p, "r": r}, a + (p * r + a * (A[1, 1] - l2)) / b,
                    {**left, "trace": float(np.trace(A)), "l2": l2, "product": p * r})


EXAMS = (
    Exam("jump", decimals(2), _jump),
    Exam("copy", decimals(1), _copy),
    Exam("bias", decimals(2), _bias),
    Exam("core", decimals(2), _core),
)
