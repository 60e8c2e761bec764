"""Draw the questions of lesson 8: decay, noise and the best poles."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve, Point
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bars, question_of_poles, question_over_time
from observer_lab.devices import design_of_run
from observer_lab.text import text

from ..toolkit.questions import board_question

ROUNDED_TO, LATE = 0.05, 20  # m; periods of the device, 0.24 s
FASTER = 2.0  # times that the poles move to the left in the recall
ALMOST_THREEFOLD = 2.0**1.5  # as much as the option says that σ grows for twice the speed


def recall(asked: Asked) -> DrawnQuestion:
    """The error without noise after the poles have moved to the left: it decays in half the time, or in twice the time."""
    now = asked.at(method="speed", speed=1.0)
    then = asked.at(method="speed", speed=FASTER)
    t, error = now.run.t, np.abs(now.study.quiet[:, 0])
    faster, slower = np.interp(np.minimum(FASTER * t, t[-1]), t, error), np.interp(t / FASTER, t, error)
    return question_over_time(text("position error without noise"), t, (Curve(text("before"), error, "muted", "dot"),), (faster, slower),
                              Curve(text("after"), np.abs(then.study.quiet[:, 0]), "error"), "|e₁| [m]")


def predict(asked: Asked) -> DrawnQuestion:
    """The deviation of the velocity's error at twice the speed: almost three times, as before, a half, or twice as large."""
    before, after = (each.metrics["velocity_rms"] for each in (asked.entry, asked.after))
    return question_of_bars(text("standard deviation of the velocity's error"), "σ [m/s]", ((text("speed 5"), before),), text("speed 10"),
                            [share * before for share in (ALMOST_THREEFOLD, 1.0, 0.5, 2.0)], after, "error")


def surprise(asked: Asked) -> DrawnQuestion:
    """The Kalman filter's poles with the worse sensor: where they were, sixteen times nearer, or half as far."""
    before, after = asked.entry.poles["kalman"], asked.after.poles["kalman"]
    known = tuple(Point(complex(s).real, complex(s).imag, "muted", "circle") for s in before)
    return question_of_poles(text("poles of the Kalman filter"), known, [np.asarray(before) * share for share in (1.0, 1 / 16, 0.5)], after)


def board(asked: Asked) -> DrawnQuestion:
    """The error of the velocity on a board, at the lesson's start with the Kalman filter's poles."""
    start = asked.lesson.apply(asked.lesson.start(), {"speed": 1.0})
    run = asked.lesson.compute(start).run
    assert run is not None
    return board_question(text("error of the velocity on a board"), "σ [m/s]", design_of_run(run), run.x, 1, step=ROUNDED_TO, late=LATE)


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise, "board": board})
