"""Draw the questions of lesson 10: poles, margins and cost."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_bars, question_of_poles
from observer_lab.text import text

from ..toolkit.questions import question_of_decades
from .loops import sensor_input

LATE = 0.7  # of a pole, in the option that says that the late estimate moves it
FIXED_SHARE = 0.5  # of the margin of LQR, in the option that says so
GUARANTEED_DEG = 60.0  # phase margin that regulator and filter have in any case, each cut at its own place
WEIGHTS = (5.0, 100.0)  # q and σ, before and after
NOISE_SHARES = (3.0, 1.0, 0.3)  # of the input from sensor noise, in the order of the options
COST_SHARES = (1.0, 0.5, 1.5, 90.0)  # of the cost now, in the order of the options


def recall(asked: Asked) -> DrawnQuestion:
    """The loop's poles: those of regulator and filter, or new ones. Only those are drawn that the boards have room for."""
    left, right = asked.entry.boards
    low, tall = max(left.re_low, right.re_low), max(left.im_high, right.im_high)

    def near(poles: Sequence[complex]) -> list[complex]:
        return [s for s in map(complex, poles) if s.real >= low and abs(s.imag) <= tall]
    both = near([*asked.entry.poles["regulator"], *asked.entry.poles["filter"]])
    return question_of_poles(text("poles of the loop"), (), (both, [LATE * s for s in both]), near(asked.entry.poles["loop"]), role="plant")


def predict(asked: Asked) -> DrawnQuestion:
    """The phase margin for two pairs of weights: that of LQR, a share of it, the 60° of both parts, or ever less."""
    outcomes = [asked.at(q=weight, sigma=weight) for weight in WEIGHTS]
    lqr = [float(np.degrees(each.study.ideal.margins.phase)) for each in outcomes]
    first, second = (float(np.degrees(each.study.real.margins.phase)) for each in outcomes)
    vanishing = FIXED_SHARE * lqr[0] * WEIGHTS[0] / WEIGHTS[1], FIXED_SHARE * lqr[0] * (WEIGHTS[0] / WEIGHTS[1]) ** 2
    return question_of_bar_groups(text("phase margin of optimal loops"), "[°]", (), (text("q = σ = 5"), text("q = σ = 100")),
                                  (lqr, [FIXED_SHARE * value for value in lqr], (GUARANTEED_DEG, GUARANTEED_DEG), vanishing),
                                  (first, second), level=(text("LQR alone"), lqr))


def surprise(asked: Asked) -> DrawnQuestion:
    """The average cost with recovery beside that without: the same, less, half as much again, or ninety times."""
    before, after = (asked.at(gain=1.0, recovery=each.design["recovery"]).study.cost.total for each in (asked.entry, asked.after))
    return question_of_decades(text("average cost J"), text("times the cost without recovery"), ((text("now"), 1.0),),
                               (text("with recovery"),), [(share,) for share in COST_SHARES], (after / before,))


def tune(asked: Asked) -> DrawnQuestion:
    """The input's part from sensor noise after β_R has grown, as a share of that before: more, as much, or less."""
    now, then = (sensor_input(each.study.case, each.study.setting) for each in (asked.entry, asked.after))
    return question_of_bars(text("input from sensor noise"), text("times the value now"), ((text("now"), 1.0),), text("with ten times β_R"),
                            NOISE_SHARES, then / now)


QUESTIONS = MappingProxyType({"recall": recall, "tune": tune, "predict": predict, "surprise": surprise})
