"""Draw the questions of lesson 16: a product, an unstable plant, a differentiator."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bars, question_over_time
from observer_lab.engine import observer_gain
from observer_lab.plants.bilinear import BILINEAR_PLANT, X0
from observer_lab.text import text

from ..toolkit.questions import driven, size

POLES_OF_A_WHOLE_OBSERVER = (-2.0, -2.5, -3.0, -3.5, -4.0, -4.5)  # rad/s, of the observer that the recalled question is about
HELD = 2.0  # the constant input of that question
OTHER_RATE = 0.3  # of the pole, in the option that says that the error has another rate


def recall(asked: Asked) -> DrawnQuestion:
    """The error of an observer of all six states under a constant input: as without it, or with other poles."""
    t, plant = asked.entry.study.run.t, BILINEAR_PLANT
    A = plant.A - observer_gain(plant.A, plant.C, POLES_OF_A_WHOLE_OBSERVER).gain @ plant.C
    e0 = np.array(X0)
    alone, other = (size(driven(A + u * plant.parts[0], e0, t)) for u in (0.0, HELD))
    return question_over_time(text("size of the error under a constant u = {u:.3g}", u=HELD), t,
                              (Curve(text("u = 0"), alone, "muted"),), (alone, other),
                              Curve(text("with the input"), other, "error"), "‖e‖", log_y=True)


def predict(asked: Asked) -> DrawnQuestion:
    """The error under u = 3: another rate, driven by u, as without an input, or growing with the plant."""
    run, pole = asked.after.study.run, asked.after.metrics["pole"]
    t, first = run.t, abs(asked.after.metrics["first_error"])
    decays = first * np.exp(pole * t)
    return question_over_time(text("size of the error ĝ − g under the step"), t,
                              (Curve(text("size of g now"), np.abs(asked.entry.study.run.g[:, 0]), "muted"),),
                              (first * np.exp(OTHER_RATE * pole * t), np.maximum(decays, np.abs(run.u)), decays, np.abs(run.g[:, 0])),
                              Curve(text("the error"), np.abs(run.errors[:, 0, 0]), "error"), "|ĝ − g|", log_y=True, span=(-12.0, 4.0))


def surprise(asked: Asked) -> DrawnQuestion:
    """The error that the differentiator leaves with a pole twice as fast: half, more as L has grown, or as before."""
    before, after = asked.entry.metrics, asked.after.metrics
    pace = after["pole"] / before["pole"]
    return question_of_bars(text("largest error in the second half of the run"), "|ĝ − g|",
                            ((text("pole {pole:.3g}", pole=before["pole"]), before["half_error"]),),
                            text("pole {pole:.3g}", pole=after["pole"]),
                            (before["half_error"] / pace, before["half_error"] * after["pi"] / before["pi"] / pace, before["half_error"]),
                            after["half_error"], "error")


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
