"""Define the exams of lesson 15."""

from __future__ import annotations

from observer_lab.course.exercises.exam import WHOLE_NUMBER, Exam, ExamItem, SeededDraws, decimals


def _criterion(lot: SeededDraws) -> ExamItem | None:
    """J of example 1 at an integer s with integer weights: 2α|s| + β|s² + 4s + 3| + γ|50 + 30s|."""
    s, a, b, c = -float(lot.whole(2, 9)), float(lot.whole(1, 4)), float(lot.whole(1, 4)), float(lot.whole(1, 4))
    L, M = -(s * s + 4 * s + 3), 50 + 30 * s
    J = 2 * a * abs(s) + b * abs(L) + c * abs(M)
    sizes = {"L": L, "M": M, "size": abs(s), "sizeL": abs(L), "sizeM": abs(M)}
    return ExamItem({"a": a, "b": b, "c": c, "s": s}, J, sizes) if J not in (30, 50) else None  # both stand in the statement


def _direct(lot: SeededDraws) -> ExamItem | None:
    """T = [t 1] with t = b + s; N = k₂ and M = k₁ − k₂ t."""
    k, b, s = float(lot.whole(2, 9)), lot.part(2, 12, 2), -float(lot.whole(2, 9))
    k1, k2 = float(lot.whole(-9, 9)), float(lot.whole(2, 6))
    return ExamItem({"k": k, "b": b, "k1": k1, "k2": k2, "s": s}, k1 - k2 * (b + s), {"t": b + s}) if abs(k1) > 1 else None


def _aside(lot: SeededDraws) -> ExamItem | None:
    """M = 0 at s = k₁/k₂ − b, where that is stable."""
    k, b, k1, k2 = float(lot.whole(2, 9)), float(lot.whole(3, 9)), float(lot.whole(2, 20)), float(lot.whole(2, 9))
    s = k1 / k2 - b
    return ExamItem({"k": k, "b": b, "k1": k1, "k2": k2}, s) if s < -0.3 else None


def _damper(lot: SeededDraws) -> ExamItem:
    """ε̇ = s ε + δ v rests at −δ v/s; ŵ − w = k₂ ε."""
    k2, s, delta, v = float(lot.whole(2, 9)), -float(lot.whole(2, 9)), lot.part(1, 9), lot.part(3, 30)
    eps = -delta * v / s
    return ExamItem({"k2": k2, "s": s, "delta": delta, "v": v}, k2 * eps, {"eps": eps})


EXAMS = (
    Exam("criterion", WHOLE_NUMBER, _criterion),
    Exam("direct", decimals(1), _direct),
    Exam("aside", decimals(2), _aside),
    Exam("damper", decimals(3), _damper),
)
