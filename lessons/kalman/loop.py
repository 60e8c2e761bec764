"""Draw the filter of lesson 9 as a block diagram, with the signals of its run."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.diagram import DiagramFigure
from observer_lab.course.lesson import Outcome

from ..toolkit.diagram import LoopSignals, loop
from .knobs import DT, MODEL
from .study import Study


def loop_of(outcome: Outcome[Study]) -> DiagramFigure:
    """Plant and filter with the gain M of the sample that is looked at."""
    truth, track = outcome.study.truth, outcome.study.track
    signals = LoopSignals(DT * np.arange(len(truth.y)), truth.u, truth.y, truth.y - track.innovations, track.means)
    return loop(MODEL.plant, signals, outcome.gains["M"], gain="M", sampled=True)
