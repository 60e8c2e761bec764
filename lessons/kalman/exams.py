"""Define the exams of lesson 9."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals


def _step(lot: SeededDraws) -> ExamItem:
    """One step of a scalar filter: p⁻ = a² p + Q, p⁺ = p⁻ R/(p⁻ + R)."""
    a, p, Q, R = lot.part(5, 14), float(lot.whole(1, 6)), float(lot.whole(1, 5)), float(lot.whole(1, 8))
    prior = a * a * p + Q
    return ExamItem({"a": a, "p": p, "Q": Q, "R": R}, prior * R / (prior + R), {"prior": prior})


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


def _joseph(lot: SeededDraws) -> ExamItem | None:
    """With a gain for another R: P⁺ = (1 − M)² P + M² R."""
    P, R, believed = float(lot.whole(2, 9)), float(lot.whole(2, 12)), float(lot.whole(2, 12))
    M = P / (P + believed)
    return ExamItem({"P": P, "R": R, "believed": believed}, (1 - M) ** 2 * P + M * M * R, {"M": M}) if believed != R else None


EXAMS = (
    Exam("step", decimals(2), _step),
    Exam("steady", decimals(3), _steady),
    Exam("nis", decimals(2), _nis),
    Exam("joseph", decimals(2), _joseph),
)
