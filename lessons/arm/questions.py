"""Draw the questions of lesson 20: an unknown force, the load that comes, no cancelling."""

from __future__ import annotations

from math import degrees, radians
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_over_time
from observer_lab.devices import design_of_run
from observer_lab.plants.arm import ANGLE_INDEX, LOAD_INDEX
from observer_lab.text import text

from ..toolkit.questions import board_question
from .loop import LOAD_AT

ROUNDED_TO, LATE = 1.0, 5  # degrees; periods of the device, 20 ms
PART = 0.5  # of the load that is found, in the option that says that a part is found
DRIFT = 0.6  # of the load in a second, in the option that says that the estimate drifts
SEEN = 3  # decimals of a bar: what is less is zero
RECALLED_LOAD = 1.5  # N m, of the recalled question


def recall(asked: Asked) -> DrawnQuestion:
    """The error of the angle under a constant force that nobody knows: it settles at a value, or it decays."""
    run = asked.at(load_state=False, load=RECALLED_LOAD).run
    error = np.degrees(run.e[:, ANGLE_INDEX])
    since, pace = np.maximum(run.t - LOAD_AT, 0.0), -asked.entry.metrics["slowest_observer"]
    rest = error[-1] * (1 - np.exp(-pace * since))
    return question_over_time(text("error of the angle; the force acts from 1 s on"), run.t, (),
                              (rest, error[-1] * pace * since * np.exp(1 - pace * since)), Curve(text("the error"), error, "error"),
                              "θ − θ̂ [°]")


def predict(asked: Asked) -> DrawnQuestion:
    """The estimate of the load: zero, the load, a part of it, or a drift."""
    run, load = asked.after.run, asked.after.design["load"]
    since, pace = np.maximum(run.t - LOAD_AT, 0.0), -asked.after.metrics["slowest_observer"]
    rises = 1 - np.exp(-pace * since)
    known = (Curve(text("load"), run.x[:, LOAD_INDEX], "plant", "dot"),)
    return question_over_time(text("estimate of the load"), run.t, known,
                              (0 * since, load * rises, PART * load * rises, load * DRIFT * since),
                              Curve(text("the estimate"), run.xhat[:, LOAD_INDEX], "estimate"), "τ̂ [N m]")


def surprise(asked: Asked) -> DrawnQuestion:
    """The errors of load and angle, and how far the arm is from its target, when the load is not cancelled."""
    load, after = abs(asked.entry.design["load"]), asked.after.metrics
    plain = asked.at(load_state=False).metrics
    spring = degrees(after["holding"] / abs(float(asked.entry.gains["K"][0, ANGLE_INDEX])))
    return question_of_bar_groups(text("at rest: errors of the estimates, distance of the arm"), text("N m or °"), (),
                                  (text("load [N m]"), text("angle [°]"), text("arm to target [°]")),
                                  ((load, 0.0, 0.0), (load, plain["angle_belief"], plain["angle_error"]), (0.0, 0.0, 0.0),
                                   (0.0, 0.0, spring)),
                                  tuple(round(after[name], SEEN) for name in ("load_error", "angle_belief", "angle_error")), "error")


def board(asked: Asked) -> DrawnQuestion:
    """The error of the load on a board, at the lesson's start."""
    run = asked.lesson.compute(asked.lesson.start()).run
    assert run is not None
    return board_question(text("error of the load on a board"), "N m", design_of_run(run), run.x, LOAD_INDEX, step=radians(ROUNDED_TO),
                          late=LATE)


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise, "board": board})
