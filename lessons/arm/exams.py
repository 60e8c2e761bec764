"""Define the exams of lesson 20."""

from __future__ import annotations

import math

from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals, significant

DEGREES = 180 / math.pi


def _holding(lot: SeededDraws) -> ExamItem:
    """At rest N k i = τ and u = R i."""
    R, k, n, tau = lot.part(3, 30), lot.part(2, 9, 100), float(lot.whole(8, 60)), lot.part(5, 60)
    i = tau / (n * k)
    return ExamItem({"R": R, "k": k, "n": n, "tau": tau}, R * i, {"i": i})


def _bias(lot: SeededDraws) -> ExamItem | None:
    """J θ̈ = T − τ without a state for τ, both poles p: 0 = −p² e₁ − τ/J."""
    J, tau, p = lot.part(5, 40, 100), lot.part(2, 30), -float(lot.whole(4, 25))
    lag = DEGREES * tau / (J * p * p)
    return ExamItem({"J": J, "tau": tau, "p": p}, lag, {"radians": lag / DEGREES}) if 0.5 < lag < 20 else None


def _product(lot: SeededDraws) -> ExamItem:
    """J θ̈ = T − τ with a state for τ: det(A_a − L C_a) = l₃/J = q₁ q₂ q₃."""
    J = lot.part(5, 40, 100)
    a, b, c = (-float(q) for q in sorted(lot.some(range(4, 25), 3)))
    return ExamItem({"J": J, "a": a, "b": b, "c": c}, J * a * b * c, {"abc": a * b * c})


def _play(lot: SeededDraws) -> ExamItem:
    """The motor alone, from flank to flank: δ = N k i t²/(2 N² J_r)."""
    n, Jr, k, i, gap = float(lot.whole(8, 60)), float(lot.whole(5, 150)), lot.part(2, 9, 100), lot.part(5, 40), lot.part(3, 25)
    rotor, delta = n**2 * Jr * 1e-7, gap / DEGREES
    return ExamItem({"n": n, "Jr": Jr, "k": k, "i": i, "gap": gap}, 1000 * math.sqrt(2 * delta * rotor / (n * k * i)),
                    {"rotor": rotor, "delta": delta, "torque": n * k * i, "seconds": math.sqrt(2 * delta * rotor / (n * k * i))})


EXAMS = (
    Exam("holding", decimals(2), _holding),
    Exam("bias", decimals(2), _bias),
    Exam("product", significant(3), _product),
    Exam("play", significant(3), _play),
)
