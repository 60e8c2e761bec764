"""Define the exams of lesson 14."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _sigma(lot: SeededDraws) -> ExamItem:
    """The mean of a x² that sigma points find, a (m² + P)."""
    a, m, P = float(lot.whole(2, 5)), float(lot.whole(2, 7)), lot.part(1, 12, 4)
    return ExamItem({"a": a, "m": m, "P": P}, a * (m * m + P))


def _update(lot: SeededDraws) -> ExamItem | None:
    """x̂⁺ = m + M (y − a m²) with H = 2 a m."""
    a, m, P, R = lot.part(2, 20), lot.part(10, 50), lot.part(2, 15), float(lot.whole(2, 9))
    y = round(a * m * m + lot.part(-40, 40), 1)
    H = 2 * a * m
    M = P * H / (H * H * P + R)
    return ExamItem({"m": m, "P": P, "a": a, "R": R, "y": y}, m + M * (y - a * m * m), {"H": H, "M": M}) if y > 0 and a != 1 else None


def _spread(lot: SeededDraws) -> ExamItem:
    """Var(a x² + v) = 4 a² m² P + 2 a² P² + R."""
    a, m, P, R = float(lot.whole(2, 4)), float(lot.whole(2, 6)), lot.part(2, 20), float(lot.whole(2, 20))
    return ExamItem({"m": m, "P": P, "a": a, "R": R}, 4 * a * a * m * m * P + 2 * a * a * P * P + R)


def _hardening(lot: SeededDraws) -> ExamItem:
    """k_x = k (1 + 3 x²/l²), ω = √(k_x/m)."""
    k, l, m, x = float(lot.whole(10, 90) * 10), float(lot.whole(10, 40)), float(lot.whole(4, 20)), float(lot.whole(3, 30))
    kx = k * (1 + 3 * x * x / (l * l))
    return ExamItem({"k": k, "l": l, "m": m, "x": x}, math.sqrt(kx / m), {"kx": kx})


EXAMS = (
    Exam("sigma", decimals(2), _sigma),
    Exam("update", decimals(3), _update),
    Exam("spread", decimals(1), _spread),
    Exam("hardening", significant(3), _hardening),
)
