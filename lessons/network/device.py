"""Give the filter of lesson 18 to a device: a packet that is lost is a missing reading."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, DeviceError, design_of_filter
from observer_lab.engine import Belief, KalmanFilter
from observer_lab.text import text

from .study import TOLD_APPLIED, Study

SAMPLE_PERIOD = text("The loop of this lesson is sampled every {dt:.6g} s; leave the period out.")


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The filter on the packets of the page's run. Packets that come late count as lost on a device. Raises DeviceError."""
    study, design = outcome.study, outcome.design
    who, run = study.watched, study.run
    s = who.sampled
    if ts is not None and abs(ts - s.plant.dt) > 1e-9 * s.plant.dt:
        raise DeviceError(SAMPLE_PERIOD.format(dt=s.plant.dt))
    kf = KalmanFilter(s.plant.A, s.plant.B, s.plant.C, s.Q, who.R, dt=s.plant.dt)
    came = run.draw.sensed[:len(run.t)] == np.arange(len(run.t))
    y = np.where(came[:, None], run.y, np.nan)
    told = run.u_applied if design["told"] == TOLD_APPLIED else run.u_asked
    plant = s.plant
    return design_of_filter(kf, Belief(run.scenario.x0 - run.draw.e0, who.steady.solution), (y, told),
                            (plant.state_names, plant.input_names, plant.output_names),
                            run.xhat if not design["jitter"] else None)
