"""Define the exams of lesson 4."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import WHOLE_NUMBER, Exam, ExamItem, SeededDraws, decimals


def _offset(lot: SeededDraws) -> ExamItem:
    """One state under a constant push d: e rests at d/o, and y − r at (d + K e)/c with K = a + c."""
    a, c, o, r = float(lot.whole(2, 6)), float(lot.whole(2, 7)), float(lot.whole(8, 16)), float(lot.whole(3, 10))
    d = float(lot.whole(1, 10))
    K = a + c
    return ExamItem({"a": a, "c": c, "o": o, "r": r, "d": d}, d * (1 + K / o) / c, {"K": K, "e": d / o})


def _peak(lot: SeededDraws) -> ExamItem:
    """x = K e₀ (e^{pt} − e^{qt})/(p − q) is largest at t = ln(q/p)/(p − q)."""
    p, q = -lot.whole(1, 6) / 2, -float(lot.whole(4, 15))
    return ExamItem({"p": p, "q": q}, math.log(q / p) / (p - q))


def _own(lot: SeededDraws) -> ExamItem:
    """One state: the compensator's pole is a − K − L = p + q − a."""
    a, p, q = float(lot.whole(2, 7)), -float(lot.whole(1, 6)), -float(lot.whole(7, 15))
    return ExamItem({"a": a, "p": p, "q": q}, p + q - a, {"K": a - p, "L": a - q})


def _leak(lot: SeededDraws) -> ExamItem | None:
    """A real pole crosses zero at a = K L/(K + L − â), before the trace vanishes at K + L − â."""
    m, K, L = lot.one((0.5, 1.5, 2.0, 2.5)), float(lot.whole(3, 9)), float(lot.whole(8, 20))
    rest = K + L - m
    return ExamItem({"m": m, "K": K, "L": L}, K * L / rest) if rest**2 > K * L and m < K else None


EXAMS = (
    Exam("offset", decimals(2), _offset),
    Exam("peak", decimals(2), _peak),
    Exam("own", WHOLE_NUMBER, _own),
    Exam("leak", decimals(2), _leak),
)
