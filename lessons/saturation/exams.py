"""The exams of lesson 7."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, decimals


def _believed(lot: Lot) -> ExamItem:
    """Double integrator, observer poles both −p, told u but given less by d: e₂ settles at −2d/p (e = x − x̂)."""
    p, limit, excess = lot.whole(2, 8), lot.whole(1, 4), lot.whole(1, 6)
    return ExamItem({"p": float(p), "asked": float(limit + excess), "limit": float(limit)}, -2.0 * excess / p, {"d": float(excess)})


EXAMS = (
    Exam("believed", decimals(2), _believed),
)
