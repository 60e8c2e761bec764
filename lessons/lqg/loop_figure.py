"""Draw the loop of lesson 10 as a block diagram, with the signals of its run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from observer_lab.course.figures.diagram import DiagramFigure
from observer_lab.course.lesson import Outcome

from ..toolkit.diagram import LoopSignals, loop
from .knobs import RECURSIVE
from .loops import computer, schedule
from .study import Study


def loop_of(outcome: Outcome[Study]) -> DiagramFigure:
    """Plant and filter: the steady gain L, or the gain M at which the recursive filter arrives in the run."""
    s = outcome.study
    run, plant = s.trace, s.case.plant
    direct = run.u @ np.asarray(plant.D).T
    signals = LoopSignals(run.t, run.u, run.x @ plant.C.T + s.setting.gain * direct, run.xhat @ plant.C.T + direct, run.xhat)
    if outcome.design["filter"] != RECURSIVE:
        return loop(plant, signals, outcome.gains["L"], outcome.gains["K"])
    f, steps = s.setting.factors, round(s.case.horizon / s.case.dt) + 1
    design = computer(s.case, replace(f, sensor=1.0), s.setting.recovery, s.case.dt)
    gains = schedule(s.case, f.beta_q, f.beta_r, s.setting.recovery, steps).gains
    return loop(plant, signals, gains[-1], design.K, gain="M", sampled=True)
