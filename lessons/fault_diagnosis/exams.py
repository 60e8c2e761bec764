"""Define the exams of lesson 17."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.exercises.exam import WHOLE_NUMBER, Exam, ExamItem, SeededDraws, decimals, significant


def _zero(lot: SeededDraws) -> ExamItem:
    """The zero of (A, E, C) for two states, the first one measured: s = d − b e₂/e₁."""
    a, b, c, d = -lot.whole(1, 4), lot.whole(1, 4), -lot.whole(1, 4), -lot.whole(1, 6)
    e1, e2 = lot.whole(1, 4), lot.one((-1, 1)) * lot.whole(1, 5)
    return ExamItem({"A": np.array([[a, b], [c, d]], float), "E": np.array([[e1], [e2]], float)}, d - b * e2 / e1,
                    {"b": float(b), "d": float(d), "e1": float(e1), "e2": float(e2)})


def _ignore(lot: SeededDraws) -> ExamItem:
    """T = I − b bᵀ/‖b‖²: t₁₁ = b₂²/‖b‖²."""
    b1, b2 = lot.part(-40, 40), lot.part(5, 40)
    size = b1 * b1 + b2 * b2
    return ExamItem({"B": np.array([[b1], [b2]])}, b2 * b2 / size, {"b1": b1, "b2": b2, "size": size})


def _delay(lot: SeededDraws) -> ExamItem | None:
    """j f/N > z σ/√N."""
    sigma, N, z, f = lot.part(2, 20), float(lot.whole(20, 200)), lot.one((2.5, 3.0, 3.5, 4.0)), lot.part(2, 40)
    tau = z * sigma / math.sqrt(N)
    least = tau * N / f
    if least > N or least < 3 or not 0.05 < least % 1 < 0.95:
        return None
    return ExamItem({"sigma": sigma, "N": N, "z": z, "f": f}, math.floor(least) + 1.0, {"tau": tau, "least": least})


def _wolves(lot: SeededDraws) -> ExamItem:
    """Members, times α, times the windows of a day."""
    members, N, rate = float(lot.whole(3, 9)), float(lot.whole(2, 20) * 10), float(lot.whole(2, 20) * 10)
    alpha = lot.one((0.001, 0.0005, 0.0002, 0.0001))
    windows = 86400 * rate / N
    return ExamItem({"members": members, "N": N, "rate": rate, "alpha": alpha}, members * alpha * windows, {"windows": windows})


EXAMS = (
    Exam("zero", decimals(2), _zero),
    Exam("ignore", decimals(3), _ignore),
    Exam("delay", WHOLE_NUMBER, _delay),
    Exam("wolves", significant(3), _wolves),
)
