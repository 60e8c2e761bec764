"""The exams of lesson 21."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _pole(lot: SeededDraws) -> ExamItem:
    """The autocovariance of a first-order state in white noise falls as a^l from the first lag on."""
    c1 = lot.whole(20, 60) / 10
    c2 = round(c1 * lot.whole(40, 92) / 100, 2)
    return ExamItem({"c1": c1, "c2": c2}, c2 / c1)


def _sensor(lot: SeededDraws) -> ExamItem | None:
    """R = c₀ − c₁²/c₂, the state's variance being c₁²/c₂."""
    c2 = lot.whole(10, 40) / 10
    c1 = c2 + lot.whole(3, 12) / 10
    c0 = round(c1 * c1 / c2 + lot.whole(5, 30) / 10, 1)
    R = c0 - c1 * c1 / c2
    return ExamItem({"c0": c0, "c1": c1, "c2": c2}, R, {"x": c1 * c1 / c2}) if R > 0.3 else None


def _band(lot: SeededDraws) -> ExamItem:
    """The mean NIS of N rows, with S from M rows, varies by √(2/N + 2/M)."""
    N, M = lot.whole(4, 20) * 50, lot.whole(4, 20) * 50
    return ExamItem({"N": float(N), "M": float(M)}, 1 + 2 * math.sqrt(2 / N + 2 / M))


def _back(lot: SeededDraws) -> ExamItem:
    """J = a P/(a² P + q)."""
    a, P, q = lot.whole(5, 11) / 10, lot.whole(5, 30) / 10, lot.whole(2, 20) / 10
    return ExamItem({"a": a, "P": P, "q": q}, a * P / (a * a * P + q), {"ahead": a * a * P + q})


EXAMS = (
    Exam("pole", decimals(2), _pole),
    Exam("sensor", decimals(2), _sensor),
    Exam("band", significant(3), _band),
    Exam("back", decimals(3), _back),
)
