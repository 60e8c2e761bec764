"""Draw the questions of lesson 6: two starts, a hidden mode, a faster controller, two setups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, Part, question_of_bar_groups, question_of_bars, question_over_time
from observer_lab.text import Text, text

from ..toolkit.questions import driven, size
from .knobs import COMMON

PACE = 1.0  # 1/s, of what an option says decays or comes to an end
OFFSET = 1.2  # times the error at the start, where an option says that it stays
NEARER, FARTHER = 0.5, 1.6  # of the distance now, in the options that say so
SPAN = (-5.0, 1.0)  # decades of the errors


def recall(asked: Asked) -> DrawnQuestion:
    """The difference of the estimates of two starts with one reading: none, or soon that of the starts."""
    run, case = asked.entry.run, asked.entry.study
    plant, L = case.model.plant, asked.entry.gains["L"]
    t, v = run.t[run.t <= 4.0], run.x[0].copy()
    v[:2], v[2:] = np.mean(v[:2]), 0.0  # both blocks alike, which the sensor does not see
    starts = driven(plant.A, v, t)
    estimates = size(driven(plant.A - L @ plant.C, 0 * v, t, starts @ plant.C.T @ L.T))
    known = (Curve(text("of the states"), size(starts), "muted", "dot"),)
    return question_over_time(text("difference of two runs with one reading"), t, known,
                              (0 * t, (1 - np.exp(-2 * PACE * t)) * size(starts)), Curve(text("of the estimates"), estimates, "estimate"),
                              "‖Δx‖, ‖Δx̂‖")


def _both(title: Text, t: np.ndarray, options: Sequence[tuple[np.ndarray, np.ndarray]], run: tuple[np.ndarray, np.ndarray]
          ) -> DrawnQuestion:
    """Two curves for each option and for the run: the error, and the innovation."""
    error, trace = (question_over_time(title, t, (), [each[k] for each in options], Curve(name, run[k], role), "‖e‖, |y − ŷ|", log_y=True,
                                       span=SPAN) for k, name, role in ((0, text("error"), "error"), (1, text("innovation"), "plant")))

    def named(parts: Sequence[Part]) -> tuple[Part, ...]:
        return tuple(replace(part, name=text("you: innovation"), dash="dot") if isinstance(part, Curve) else part for part in parts)
    return DrawnQuestion(error.figure, tuple((*a, *named(b)) for a, b in zip(error.options, trace.options, strict=True)),
                         (*error.run, *trace.run))


def predict(asked: Asked) -> DrawnQuestion:
    """Error and innovation with the magnets: the error grows unseen, decays, grows and is seen, or ends at an offset."""
    run = asked.after.run
    t, error, trace = run.t, size(run.e), np.abs(run.y - run.yhat)[:, 0]
    start, seen = error[0], trace[0]
    visible = max(pole.real for pole in asked.after.design["observer_part"])
    grows = size(driven(run.scenario.plant.A, COMMON.T @ COMMON @ run.e[0], t))
    quiet = seen * np.exp(visible * t)
    return _both(text("estimation error and innovation"), t, (
        (grows, quiet), (start * np.exp(-PACE * t), quiet), (grows, seen / grows[0] * grows),
        (start * (1 + (OFFSET - 1) * (1 - np.exp(-PACE * t))), quiet)), (error, trace))


def surprise(asked: Asked) -> DrawnQuestion:
    """How far from rest the blocks end with a faster controller: at rest, nearer, farther, or as now."""
    now = asked.entry.metrics["state_end"]
    return question_of_bars(text("size of the state at the end of the run"), "‖x‖", ((text("now"), now),),
                            text("with the faster controller"), (0.0, NEARER * now, FARTHER * now, now), asked.after.metrics["state_end"])


def detectable(asked: Asked) -> DrawnQuestion:
    """With which setup an observer's error decays: with none, with both, or with the soft springs alone."""
    soft, magnets = (float(outcome.metrics["error_rate"]) for outcome in (asked.after, asked.entry))
    usual = (abs(soft) + abs(magnets)) / 2
    return question_of_bar_groups(text("slowest part of the error: below zero it decays"), text("rate [1/s]"), (),
                                  (text("soft springs"), text("magnets")), ((usual, usual), (-usual, -usual), (-usual, usual)),
                                  (soft, magnets))


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise, "detectable": detectable})
