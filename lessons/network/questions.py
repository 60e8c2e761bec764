"""Draw the questions of lesson 18: a wrong force, tolerable loss, a late input."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bars, question_over_time
from observer_lab.text import text

from .study import LOSSES, bounds_over_loss, key

STEPS = 25  # samples of the recalled question
WRONG_FORCE = 0.5  # by how much the observer's force is wrong there
MOVED = 0.5  # how far of the way to the unit circle the poles move, in the option that says so
DIVERGES = 3.0  # the power of ten at which a mean that diverges is drawn
AIR = 0.6  # decades above that line
SAID_RADIUS = 0.95  # as an option says


def recall(asked: Asked) -> DrawnQuestion:
    """The error with a wrong force: as before, with a term added, or with other poles."""
    plant = asked.entry.study.watched.sampled.plant
    A = plant.A - asked.entry.gains["L"] @ plant.C
    moved = A + MOVED * (np.eye(plant.n) - A)
    push = WRONG_FORCE * plant.B[:, 0]

    def error(A: np.ndarray, b: np.ndarray) -> np.ndarray:
        e = [np.eye(plant.n)[0]]
        for _ in range(STEPS):
            e.append(A @ e[-1] + b)
        return np.array(e)[:, 0]
    none = np.zeros(plant.n)
    with_term = error(A, push)
    return question_over_time(text("error of the estimate"), np.arange(STEPS + 1.0), (), (error(A, none), with_term, error(moved, none)),
                              Curve(text("with the wrong force"), with_term, "error"), "e", text("sample"))


def predict(asked: Asked) -> DrawnQuestion:
    """The mean variance over the share lost, finite below a limit of 1, 0, 1/a or 1/a²; a line above stands for one that diverges."""
    lower = bounds_over_loss(key(asked.entry.design))[0]
    least, radius, top = float(lower[0]), asked.entry.metrics["radius"], 10.0**DIVERGES

    def finite_below(limit: float) -> np.ndarray:
        share = np.minimum(LOSSES / max(limit, 1e-9), 1.0)
        return np.minimum(least / np.maximum(1 - share, 1e-12), top)
    run = np.where(asked.entry.metrics["critical"] <= LOSSES, top, np.minimum(lower, top))
    return question_over_time(text("mean error variance"), LOSSES, (Curve(text("diverges"), np.full(len(LOSSES), top), "muted", "dot"),),
                              (finite_below(1.0), finite_below(0.0), finite_below(1 / radius), finite_below(1 / radius**2)),
                              Curve(text("least mean variance"), run, "error"), "P / P₀", text("share of packets lost"), log_y=True,
                              span=(float(np.floor(np.log10(least))) - 0.5, DIVERGES + AIR))


def surprise(asked: Asked) -> DrawnQuestion:
    """The radius of the loop with a late input: as designed, as large as the ball's own, or as the option says."""
    designed = asked.entry.metrics["loop_radius"]
    return question_of_bars(text("spectral radius of the loop"), "", ((text("no delay"), designed),), text("one sample late"),
                            (designed, asked.after.metrics["radius"], SAID_RADIUS), asked.after.metrics["loop_radius"], "error")


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
