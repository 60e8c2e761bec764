"""Draw the questions of lesson 11: coils and the rotation."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_bars
from observer_lab.plants.platform import model
from observer_lab.plants.platform.lqg_weights import COIL_COUNT, lqg
from observer_lab.text import text

LEAST_REACTION = 1e-2  # of the largest force: so small a force is no reaction
GROWS_DB, FALLS_DB = 12.0, -40.0  # how much the options say that a peak grows or falls
LOWER_DB, A_FEW_DB, NEARLY_DB = -12.0, 7.0, -5.0  # beside the peak without mixing; beside it again; beside that without control


def recall(asked: Asked) -> DrawnQuestion:
    """Which coils react to one wrong reading: the nearest, all, or none."""
    made = lqg(model.plant())
    at_once = np.abs(made.K @ made.L[:, 0])
    reacts = (at_once > LEAST_REACTION * at_once.max()).astype(float)
    return question_of_bar_groups(text("coils that react to one wrong reading"), text("1: reacts"), ((text("the wrong sensor"), 1.0),),
                                  tuple(text("coil {number}", number=k + 1) for k in range(COIL_COUNT)),
                                  ((1, 0, 0), (1, 1, 1), (0, 0, 0)), reacts, "force")


def predict(asked: Asked) -> DrawnQuestion:
    """The peak of the rotation beside that without control, pitch open and closed: as it was, higher, lower, or lower with pitch."""
    closed = asked.lesson.compute(asked.lesson.apply(asked.after.design, {"pitch": True}))
    run = [-each.metrics["rotation"] for each in (asked.after, closed)]
    return question_of_bar_groups(text("peak of the rotation beside that without control"), "[dB]", (),
                                  (text("pitch loop open"), text("pitch loop closed")),
                                  ((0.0, 0.0), (GROWS_DB, GROWS_DB), (FALLS_DB, FALLS_DB), (0.0, FALLS_DB)), run,
                                  level=(text("now"), (-asked.entry.metrics["rotation"],) * 2))


def surprise(asked: Asked) -> DrawnQuestion:
    """The peak of the rotation with the mixing: lower still, the same, a few decibels higher, or nearly as without control."""
    before, after = (-each.metrics["rotation"] for each in (asked.entry, asked.after))
    drawn = question_of_bars(text("peak of the rotation beside that without control"), "[dB]", ((text("without mixing"), before),),
                             text("with mixing"), (before + LOWER_DB, before, before + A_FEW_DB, NEARLY_DB), after)
    return replace(drawn, figure=replace(drawn.figure, y_range=(1.1 * (before + LOWER_DB), 0.0)))


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
