"""Define the exams of lesson 16."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _pole(lot: SeededDraws) -> ExamItem:
    """Scalar A*, B* and a pole p: π = (A* − p)/B*."""
    a, b, p = -lot.part(10, 89), lot.part(11, 48), -float(lot.whole(12, 44))
    return ExamItem({"a": a, "b": b, "p": p}, (a - p) / b)


def _patience(lot: SeededDraws) -> ExamItem:
    """ε = ε(0) e^{pt} whatever the input does."""
    p, e0, e1 = -float(lot.whole(8, 40)), float(lot.whole(3, 40)), lot.one((0.01, 0.02, 0.05, 0.1, 0.2))
    return ExamItem({"p": p, "e0": e0, "u": lot.part(10, 40), "run": lot.part(10, 60), "e1": e1}, 1000 * math.log(e0 / e1) / -p,
                    {"seconds": math.log(e0 / e1) / -p})


def _silence(lot: SeededDraws) -> ExamItem | None:
    """L q = f silences the input and L p = a − pole places the pole: two equations for l₁ and l₂."""
    p1, p2, q1, q2 = (float(lot.whole(-5, 5)) for _ in range(4))
    a, f, pole = float(lot.whole(-5, 5)), float(lot.whole(-5, 5)), -float(lot.whole(6, 15))
    det = q1 * p2 - p1 * q2
    if min(map(abs, (p1, p2, q1, q2))) < 2 or a * f == 0 or abs(det) < 3:
        return None
    l1 = (f * p2 - (a - pole) * q2) / det
    return ExamItem({"A3": np.array([[p1], [p2], [a]]), "F3": np.array([[q1], [q2], [f]]), "p": pole}, l1,
                    {"p1": p1, "p2": p2, "q1": q1, "q2": q2, "a": a, "f": f})


def _lag(lot: SeededDraws) -> ExamItem:
    """ε̇ = p ε − L ÿ τ rests at L ÿ τ/p."""
    p, L, tau, c = -float(lot.whole(4, 30)), lot.part(20, 190), float(lot.whole(3, 40)), float(lot.whole(2, 20))
    return ExamItem({"p": p, "L": L, "tau": tau, "c": c}, L * c * tau / (1000 * p), {"seconds": tau / 1000})


EXAMS = (
    Exam("pole", decimals(2), _pole),
    Exam("patience", significant(3), _patience),
    Exam("silence", decimals(2), _silence),
    Exam("lag", significant(3), _lag),
)
