"""Draw the filter of lesson 9 as a block diagram, with the signals of its run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from observer_lab.course.figures.diagram import DiagramFigure
from observer_lab.course.lesson import Outcome

from ..toolkit.diagram import loop
from .knobs import DT, MODEL
from .study import Study


class Filtered(NamedTuple):
    """The signals of a filter's run, as a diagram takes them."""

    t: np.ndarray
    u_applied: np.ndarray
    y: np.ndarray
    yhat: np.ndarray
    xhat: np.ndarray


def loop_of(outcome: Outcome[Study]) -> DiagramFigure:
    """Plant and filter with the gain M of the sample that is looked at."""
    truth, track = outcome.study.truth, outcome.study.track
    signals = Filtered(DT * np.arange(len(truth.y)), truth.u, truth.y, truth.y - track.innovations, track.means)
    return loop(MODEL.plant, signals, outcome.gains["M"], gain="M", sampled=True)
