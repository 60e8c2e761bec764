"""Define the exams of lesson 7."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _believed(lot: SeededDraws) -> ExamItem:
    """Double integrator, observer poles both p, told more than is given: e₂ settles at −2 (u − u_c)/p (e = x − x̂)."""
    p, limit, excess = -float(lot.whole(2, 8)), float(lot.whole(1, 4)), float(lot.whole(1, 6))
    return ExamItem({"p": p, "asked": limit + excess, "limit": limit}, 2 * excess / p, {"e1": -excess / p**2})


def _windup(lot: SeededDraws) -> ExamItem:
    """Back-calculation rests where k_i e + (u − v)/T_t = 0."""
    U, ki, Tt, e = float(lot.whole(2, 9)), float(lot.whole(2, 15)), lot.part(2, 20), lot.part(2, 15)
    return ExamItem({"U": U, "ki": ki, "Tt": Tt, "e": e}, U + Tt * ki * e)


def _reach(lot: SeededDraws) -> ExamItem | None:
    """ẋ = a x + b u is lost beyond b U/a; waiting costs e^{aτ}."""
    a, b, U, tau = lot.part(2, 20), float(lot.whole(2, 6)), float(lot.whole(2, 9)), lot.part(1, 12)
    edge = b * U / a
    return ExamItem({"a": a, "b": b, "U": U, "tau": tau}, edge * math.exp(-a * tau), {"edge": edge}) if a != 1 else None


def _fastest(lot: SeededDraws) -> ExamItem:
    """From rest to rest over d with |u| ≤ U: t = 2 √(m d/U)."""
    m, d, U = float(lot.whole(2, 12)), lot.part(2, 30), float(lot.whole(2, 15))
    return ExamItem({"m": m, "d": d, "U": U}, 2 * math.sqrt(m * d / U))


EXAMS = (
    Exam("believed", decimals(2), _believed),
    Exam("windup", decimals(1), _windup),
    Exam("reach", significant(3), _reach),
    Exam("fastest", decimals(2), _fastest),
)
