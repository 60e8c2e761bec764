"""Draw the questions of lesson 3: the correction, two starts, motions that are seen, a better sensor."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_bars, question_over_time
from observer_lab.text import text

SIDEWAYS, UPWARD, PITCH = text("horizontal"), text("vertical"), text("pitch")
POSITIONS, VELOCITIES = (0, 1, 2), (3, 4, 5)  # of the deck: where horizontal, vertical and pitch stand in the state


def recall(asked: Asked) -> DrawnQuestion:
    """How much of each velocity's error the correction contains: all of it, or as much as the reading does."""
    shown = np.abs(asked.entry.study.sensed.plant.C).max(axis=0)[list(VELOCITIES)]
    shown = tuple(float(v) for v in shown / max(shown.max(), 1e-300))
    return question_of_bar_groups(text("part of each velocity's error in y − Cx̂"), text("share"), (), (SIDEWAYS, UPWARD, PITCH),
                                  ((1.0, 1.0, 1.0), shown), shown)


def twins(asked: Asked) -> DrawnQuestion:
    """The difference of the two readings: it grows while one records, or stays zero."""
    study = asked.entry.study
    first, second = study.twins.readings
    t, gap = study.sensed.t, np.abs(second - first).max(axis=1)
    return question_over_time(text("difference of the two readings"), t, (), (float(np.abs(study.twins.v).max()) * t / t[-1], 0 * t),
                              Curve(text("the difference"), gap), text("Δy, in typical readings"))


def predict(asked: Asked) -> DrawnQuestion:
    """What the readings tell of each motion: all, none, vertical and pitch, or vertical alone."""
    P = asked.after.study.belief.P[-1]
    learned = tuple(1 - float(np.sqrt(P[k, k])) for k in POSITIONS)
    return question_of_bar_groups(text("uncertainty that the readings remove"), text("share"), (), (SIDEWAYS, UPWARD, PITCH),
                                  ((1, 1, 1), (0, 0, 0), (0, 1, 1), (0, 1, 0)), learned)


def surprise(asked: Asked) -> DrawnQuestion:
    """The longest half axis with a better sensor: as before, shorter in proportion to the noise, or shorter by less."""
    now, ratio = asked.entry.metrics["longest"], asked.after.design["noise"] / asked.entry.design["noise"]
    return question_of_bars(text("longest half axis of the cloud"), text("half axis"), ((text("now"), now),),
                            text("with the better sensor"), (now, ratio * now, np.sqrt(ratio) * now), asked.after.metrics["longest"])


QUESTIONS = MappingProxyType({"recall": recall, "twins": twins, "predict": predict, "surprise": surprise})
