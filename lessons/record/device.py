"""Give the fitted filter of a record to a device."""

from __future__ import annotations

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, DeviceError, design_of_filter
from observer_lab.engine import Belief
from observer_lab.text import text

from .study import Study

RECORDED_PERIOD = text("The record has a row each {dt:.6g} s, and the filter is fitted to that; leave the period out.")


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The filter with its gate along the record, about the record's level. Raises DeviceError for another period."""
    study = outcome.study
    record, fitted, track = study.found.record, study.found.fitted, study.judged.track
    kf = fitted.kalman(factor=study.factor)
    if ts is not None and abs(ts - record.dt) > 1e-9 * record.dt:
        raise DeviceError(RECORDED_PERIOD.format(dt=record.dt))
    start = Belief(0 * track.means[0], track.schedule.prior[0])
    names = (fitted.plant.state_names, record.input_names, record.output_names)
    gate = float(outcome.design["gate"]) if study.gated else None
    return design_of_filter(kf, start, (record.y, record.u), names, track.means, gate=gate)
