"""The exams of lesson 13."""

from __future__ import annotations

from app.lesson.exam import Exam, ExamItem, Lot, significant


def _sampled(lot: Lot) -> ExamItem:
    """Two coils with u = −k v each on a free mass m, sampled at f and held: v⁺ = (1 − 2k/(m f)) v, stable up to k = m f."""
    m, f = lot.whole(4, 24), lot.one((200, 250, 400, 500, 800, 1000, 1200, 1600, 2000))
    return ExamItem({"m": float(m), "f": float(f)}, float(m * f))


EXAMS = (
    Exam("sampled", significant(3), _sampled),
)
