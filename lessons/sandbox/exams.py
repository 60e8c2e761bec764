"""Define the exams of lesson 19."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _silent(lot: SeededDraws) -> ExamItem:
    """A = [a 1; 0 b], C = [1 c]: the mode at b has the direction (1, b − a) and is hidden where 1 + c (b − a) = 0."""
    a, b = (lot.part(-90, -1) for _ in range(2))
    return ExamItem({"a": a, "b": b}, 1.0 / (a - b) if a != b else math.inf, {"gap": b - a})


def _zero(lot: SeededDraws) -> ExamItem:
    """The numerator (s + b) b₁ + b₂ vanishes at −b − b₂/b₁."""
    k, b, b1, b2 = float(lot.whole(2, 9)), lot.part(2, 15, 2), float(lot.whole(2, 6)), float(lot.whole(-20, 20))
    return ExamItem({"k": k, "b": b, "B": np.array([[b1], [b2]])}, -b - b2 / b1, {"b1": b1, "b2": b2})


def _static(lot: SeededDraws) -> ExamItem | None:
    """−C A⁻¹ B of a stable plant of two states."""
    A = np.array([[lot.whole(-6, 2), lot.whole(-5, 5)], [lot.whole(-5, 5), lot.whole(-6, -1)]], float)
    B = np.array([[float(lot.whole(-5, 5))], [float(lot.whole(2, 6))]])
    (a11, a12), (a21, a22) = A.tolist()
    det = a11 * a22 - a12 * a21
    if a11 + a22 >= 0 or det < 2 or 0 in (a12, a21, B[0, 0]):
        return None
    left = {"a11": a11, "a12": a12, "a21": a21, "a22": a22, "b1": float(B[0, 0]), "b2": float(B[1, 0]), "det": det}
    return ExamItem({"A": A, "B": B}, -(a22 * B[0, 0] - a12 * B[1, 0]) / det, left)


def _held(lot: SeededDraws) -> ExamItem:
    """λ = ln z/h."""
    z, h = lot.part(15, 140, 100), float(lot.whole(5, 200))
    return ExamItem({"z": z, "h": h}, 1000 * math.log(z) / h, {"seconds": h / 1000})


EXAMS = (
    Exam("silent", decimals(2), _silent),
    Exam("zero", decimals(2), _zero),
    Exam("static", decimals(2), _static),
    Exam("held", significant(3), _held),
)
