"""Draw the questions of lesson 9: the gain, NIS and NEES."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups
from observer_lab.course.lesson import Outcome
from observer_lab.text import text

from ..toolkit.questions import board_question, question_of_decades
from .all_records import expected
from .device import device
from .filters import UNTESTED_SAMPLES
from .knobs import WHITE
from .study import Study

VZ, ROUNDED_TO, GROWS = 4, 1e-3, 10.0  # place of the vertical velocity; m/s; times by which an option lets its cause enlarge the error
LARGER = 16.0  # times that a noise grows in the recall
WRONG_START = 3.0  # times that the errors are as large as expected at the start, in the option that says so


def recall(asked: Asked) -> DrawnQuestion:
    """The gain where Q grows, and where Q and R grow alike: it follows R alone, or the ratio."""
    def gain(outcome: Outcome[Study]) -> float:
        return float(np.linalg.norm(outcome.gains["M_riccati"]))
    now, only_r, more_q, both = (gain(asked.at(q=q, r=r)) for q, r in ((1.0, 1.0), (1.0, LARGER), (LARGER, 1.0), (LARGER, LARGER)))
    only_r, more_q, both = only_r / now, more_q / now, both / now
    return question_of_bar_groups(text("size of the gain"), text("times the gain now"), ((text("now"), 1.0),),
                                  (text("W 16 times"), text("W and V 16 times")), ((1.0, only_r), (more_q, 1.0)), (more_q, both))


def predict(asked: Asked) -> DrawnQuestion:
    """How large the errors are beside what the filter states, before 2 s and after: as stated, wrong at first, too large, too small."""
    study, n = asked.entry.study, 6
    all_along = np.sqrt(expected(WHITE, asked.entry.design["q"], asked.entry.design["r"]).nees / n)
    small = np.sqrt(asked.entry.metrics["nis_mean"] / n)
    first, later = (float(np.sqrt(np.mean(part) / n)) for part in (study.nees[:UNTESTED_SAMPLES], study.nees[UNTESTED_SAMPLES:]))
    return question_of_bar_groups(text("errors of the states beside what the filter states"), text("times the stated σ"), (),
                                  (text("first 2 s"), text("after 2 s")),
                                  ((1.0, 1.0), (WRONG_START, 1.0), (all_along, all_along), (small, small)), (first, later), "error")


def surprise(asked: Asked) -> DrawnQuestion:
    """NEES with a Q that is much too large: about 2, above 61 as the factor is larger, or 6."""
    before, after = asked.entry.metrics["nees_mean"], asked.after.metrics["nees_mean"]
    factors = asked.after.design["q"], 1 / asked.entry.design["q"]
    return question_of_decades(text("mean of NEES"), "NEES", ((text("Q 20 times too small"), before),), (text("Q 100 times too large"),),
                               ((2.0,), (before * factors[0] / factors[1],), (6.0,)), (after,), "error")


def board(asked: Asked) -> DrawnQuestion:
    """The error of the vertical velocity on a board, with Q and R as they are."""
    outcome = asked.lesson.compute(asked.lesson.start())
    return board_question(text("error of the vertical velocity on a board"), "σ [mm/s]", device(outcome), outcome.study.truth.x, VZ,
                          step=ROUNDED_TO, late=1, grows=GROWS, scale=1e3)


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise, "board": board})
