"""Give the computer of lesson 10 to a device: its filter, steady or recursive, and K."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, kalman_routine, observer_routine
from observer_lab.engine import Belief, KalmanFilter, Plant
from observer_lab.engine.filters import Schedule
from observer_lab.text import text

from .knobs import RECURSIVE
from .loops import RUN_STATE_LIMIT, computer, first_belief
from .study import Study

REDESIGNED = text("K and filter are designed again for {ts:.3g} s: plant, cost and noise are sampled exactly with the input held.")


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The sampled loop of the design from the page's start, without noise."""
    study, design = outcome.study, outcome.design
    case, setting = study.case, study.setting
    period = case.dt if ts is None else ts
    sampled = computer(case, replace(setting.factors, sensor=1.0), setting.recovery, period)
    kf, p, recursive = sampled.filter, case.plant, design["filter"] == RECURSIVE
    steps = max(round(case.horizon / period), 2) + 1
    names, guess = (p.state_names, p.input_names, p.output_names), np.asarray(case.model.guess, dtype=float)
    rule = REDESIGNED.format(ts=period)
    if recursive:
        routine = replace(kalman_routine(kf.A, kf.B, kf.C, kf.Q, kf.R, (guess, first_belief(case)), period, names, K=sampled.K), rule=rule)
    else:
        routine = observer_routine(replace(sampled.plant, state_names=p.state_names), sampled.K, kf.steady.filter_gain, guess, rule,
                                   current=True)
    s, gains = sampled.plant, _schedule(kf, first_belief(case), steps) if recursive else None
    with np.errstate(over="ignore", invalid="ignore"):
        run = sampled.run(case.model.x0, np.zeros((steps, p.n)), np.zeros((steps, p.p)), gains=gains, xhat0=guess,
                          truth=Plant(s.A, setting.gain * s.B, s.C, s.D, s.dt))
    sane = np.isfinite(run.x).all(axis=1) & (np.abs(run.x).max(axis=1) < RUN_STATE_LIMIT)
    keep = slice(0, int(np.argmin(np.append(sane, False))))
    return DeviceDesign(routine, run.y[keep], run.u[keep], None, run.xhat[keep])


def _schedule(kf: KalmanFilter, first: np.ndarray, steps: int) -> Schedule:
    return kf.schedule(Belief(np.zeros(kf.n), first), steps)
