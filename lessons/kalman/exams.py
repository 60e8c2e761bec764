"""Define the exams of lesson 9."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals


def _sheet(lot: SeededDraws) -> ExamItem:
    """From data sheet to variance: R = n²/(2T) + Δ²/12, Q = d² T/2, and one step of the filter."""
    n, T, step, d, p = lot.part(1, 5), lot.one((0.01, 0.02, 0.05, 0.1)), lot.part(5, 30), lot.part(10, 60), lot.part(1, 20)
    R, Q = n * n / (2 * T) + step * step / 12, d * d * T / 2
    prior = p + Q
    return ExamItem({"n": n, "step": step, "T": T, "d": d, "p": p}, prior * R / (prior + R), {"R": R, "Q": Q, "prior": prior})


def _steady(lot: SeededDraws) -> ExamItem:
    """x⁺ = x + w: p² − Q p − Q R = 0 and M = p/(p + R)."""
    Q, R = lot.part(1, 40), float(lot.whole(2, 15))
    prior = (Q + math.sqrt(Q * Q + 4 * Q * R)) / 2
    return ExamItem({"Q": Q, "R": R}, prior / (prior + R), {"prior": prior})


def _nis(lot: SeededDraws) -> ExamItem | None:
    """ν²/S with S = c² P + R."""
    xhat, P, R, c, y = lot.part(10, 60), lot.part(2, 30), lot.part(5, 40), float(lot.whole(2, 4)), lot.part(10, 200)
    nu, S = y - c * xhat, c * c * P + R
    return ExamItem({"xhat": xhat, "P": P, "c": c, "R": R, "y": y}, nu * nu / S, {"nu": nu, "S": S}) if 0.1 < nu * nu / S < 20 else None


def _late(lot: SeededDraws) -> ExamItem:
    """u = −a x̂(k|k−1) leaves a² p + Q, p² − (Q + (a² − 1) R) p − Q R = 0."""
    a, Q, R = lot.part(11, 19), float(lot.whole(1, 6)), float(lot.whole(2, 9))
    b = Q + (a * a - 1) * R
    prior = (b + math.sqrt(b * b + 4 * Q * R)) / 2
    return ExamItem({"a": a, "Q": Q, "R": R}, a * a * prior + Q, {"b": b, "prior": prior})


EXAMS = (
    Exam("sheet", decimals(3), _sheet),
    Exam("steady", decimals(3), _steady),
    Exam("nis", decimals(2), _nis),
    Exam("late", decimals(2), _late),
)
