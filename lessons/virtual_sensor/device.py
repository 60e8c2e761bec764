"""Give the observer of lesson 1 to a device, of full or of reduced order."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.devices import HELD_READINGS, DeviceDesign, design_of_run, linear_routine, sampled_observer
from observer_lab.engine.observers import reduced_observer

from .study import Study


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The observer on the page's run. Raises DeviceError where it cannot be sampled so."""
    assert outcome.run is not None
    seen = outcome.study.reduced
    if seen is None:
        return design_of_run(outcome.run, ts)
    run, s = outcome.run, outcome.run.scenario
    every = max(1, round((s.dt if ts is None else ts) / s.dt))
    period = every * s.dt
    o = reduced_observer(s.model, (float(np.max(np.real(outcome.design["observer_poles"]))),))
    F, G, H = sampled_observer(o.F, (o.G, o.H), period)
    start = o.S @ np.asarray(s.xhat0) - (o.N @ (run.y[0] - run.yhat[0])) @ o.M
    routine = linear_routine("reduced-order observer", period, {"F": F, "L": G, "H": H, "N": o.M, "M": o.N}, start,
                             (s.plant.state_names, s.plant.input_names, s.plant.output_names), HELD_READINGS.format(ts=period))
    return DeviceDesign(routine, run.y[::every], run.u_applied[::every], None, seen[::every])
