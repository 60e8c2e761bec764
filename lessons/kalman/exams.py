"""The exams of lesson 9."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _step(lot: Lot) -> ExamItem:
    """One step of a scalar filter: p⁻ = a² p + Q, p⁺ = p⁻ R/(p⁻ + R)."""
    a, p, Q, R = lot.part(5, 14), lot.whole(1, 6), lot.whole(1, 5), lot.whole(1, 8)
    prior = a * a * p + Q
    return ExamItem({"a": a, "p": float(p), "Q": float(Q), "R": float(R)}, prior * R / (prior + R), {"prior": prior})


EXAMS = (
    Exam("step", decimals(2), _step),
)
