"""Define the exams of lesson 13."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant


def _sampled(lot: SeededDraws) -> ExamItem:
    """Two coils with u = −k v each on a free mass m, sampled at f and held: v⁺ = (1 − 2k/(m f)) v, stable up to k = m f."""
    m, f = float(lot.whole(4, 24)), float(lot.one((200, 250, 400, 500, 800, 1000, 1200, 1600, 2000)))
    return ExamItem({"m": m, "f": f}, m * f)


def _passive(lot: SeededDraws) -> ExamItem | None:
    """An undamped spring: |z/w| = 1/(ω² m/k − 1) above its resonance."""
    m, k, f = float(lot.whole(5, 20)), float(lot.whole(10, 80) * 10), lot.part(15, 80)
    omega = 2 * math.pi * f
    ratio = omega**2 * m / k - 1
    return ExamItem({"m": m, "k": k, "f": f}, 20 * math.log10(ratio), {"omega": omega}) if 2 < ratio < 1000 else None


def _late(lot: SeededDraws) -> ExamItem:
    """k/(m s) e^{−sτ} is stable up to k = π m/(2 τ)."""
    m, tau = float(lot.whole(4, 24)), float(lot.whole(2, 40))
    return ExamItem({"m": m, "tau": tau}, 1000 * math.pi * m / (2 * tau), {"seconds": tau / 1000})


def _rounding(lot: SeededDraws) -> ExamItem:
    """Steps of 2U/2^N volts: a deviation of one step over √12, in µV."""
    bits, U = lot.whole(8, 16), lot.one((2.0, 2.5, 3.0, 4.0, 5.0, 10.0))
    width = 2 * U / 2**bits
    return ExamItem({"bits": float(bits), "U": U}, 1e6 * width / math.sqrt(12),
                    {"steps": 2.0**bits, "width": width, "volts": width / math.sqrt(12)})


EXAMS = (
    Exam("sampled", significant(3), _sampled),
    Exam("passive", decimals(1), _passive),
    Exam("late", significant(3), _late),
    Exam("rounding", significant(3), _rounding),
)
