"""Draw the filter of lesson 9 as a block diagram, with the signals of its run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from observer_lab.course.figures.diagram import DiagramFigure
from observer_lab.course.lesson import Outcome

from ..toolkit.diagram import LoopSignals, loop
from .deck_study import DeckStudy
from .knobs import DT, MODEL


def loop_of(outcome: Outcome[DeckStudy]) -> DiagramFigure:
    """Plant and filter; of the gain M, which has two dozen entries, stands the size alone."""
    truth, track = outcome.study.truth, outcome.study.track
    signals = LoopSignals(DT * np.arange(len(truth.y)), truth.u, truth.y, truth.y - track.innovations, track.means)
    M = outcome.gains["M"]
    drawn = loop(MODEL.plant, signals, M, gain="M", sampled=True)
    sized = rf"M\quad ({M.shape[0]}\times {M.shape[1]})"
    return replace(drawn, blocks=tuple(replace(block, law=sized) if block.id == "L" else block for block in drawn.blocks))
