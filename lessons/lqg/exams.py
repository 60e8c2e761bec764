"""Define the exams of lesson 10."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import WHOLE_NUMBER, Exam, ExamItem, SeededDraws, decimals, significant


def _doyle(lot: SeededDraws) -> ExamItem:
    """By how many per cent may the input's gain exceed the model's: 100/(d f), f = 2 + √(4 + q) and d = 2 + √(4 + σ)."""
    root_q, root_s = lot.whole(3, 12), lot.whole(3, 12)
    f, d = 2.0 + root_q, 2.0 + root_s
    return ExamItem({"q": root_q**2 - 4.0, "sigma": root_s**2 - 4.0}, 100 / (d * f), {"f": f, "d": d})


def _cost(lot: SeededDraws) -> ExamItem:
    """One state: J = W S + K² R P, with S = R K and P = V L; the roots are whole."""
    a, R, V = float(lot.whole(2, 3)), float(lot.whole(2, 4)), float(lot.whole(2, 4))
    K, L = 2 * a + lot.whole(1, 4), 2 * a + lot.whole(1, 4)
    Q, W = R * (K * K - 2 * a * K), V * (L * L - 2 * a * L)
    return ExamItem({"a": a, "W": W, "V": V, "Q": Q, "R": R}, W * R * K + K * K * R * V * L, {"K": K, "L": L})


def _regulator(lot: SeededDraws) -> tuple[dict[str, float], float]:
    """An unstable plant with weights, and the gain of its LQR."""
    a, Q, R = float(lot.whole(2, 7)), float(lot.whole(2, 40)), lot.one((0.5, 2.0, 4.0, 5.0, 8.0))
    return {"a": a, "Q": Q, "R": R}, a + math.sqrt(a * a + Q / R)


def _drop(lot: SeededDraws) -> ExamItem:
    """a − m K = 0 at m = a/K."""
    given, K = _regulator(lot)
    return ExamItem(given, given["a"] / K, {"K": K})


def _phase(lot: SeededDraws) -> ExamItem:
    """K/(s − a) crosses one at ω = √(K² − a²), where the margin is arctan(ω/a)."""
    given, K = _regulator(lot)
    omega = math.sqrt(K * K - given["a"] ** 2)
    return ExamItem(given, math.degrees(math.atan(omega / given["a"])), {"K": K, "omega": omega})


EXAMS = (
    Exam("doyle", significant(3), _doyle),
    Exam("cost", WHOLE_NUMBER, _cost),
    Exam("drop", decimals(3), _drop),
    Exam("phase", decimals(1), _phase),
)
