"""Give the filter of lesson 9 to a device, on the deck or on an own plant."""

from __future__ import annotations

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, DeviceError, design_of_filter
from observer_lab.engine import Belief
from observer_lab.text import text

from .knobs import MODEL
from .own_study import Study as OwnStudy
from .study import Study

ONE_PERIOD = text("This filter is made for its own period of {dt:.6g} s; leave the period out.")


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The filter on the record that the page shows. Raises DeviceError for another period."""
    study: Study | OwnStudy = outcome.study
    if isinstance(study, OwnStudy):
        found = study.found
        kf, track, run = found.filter, found.track, found.run
        plant = run.scenario.plant
        start, record, page = Belief(0 * track.means[0], track.schedule.prior[0]), (run.y, run.u_applied), track.means
    else:
        kf, start, page, plant = study.watcher.filter, study.watcher.start, study.track.means, MODEL.plant
        record = study.truth.y, study.truth.u
    if ts is not None and abs(ts - kf.dt) > 1e-9 * kf.dt:
        raise DeviceError(ONE_PERIOD.format(dt=kf.dt))
    states = (*plant.state_names, *(f"noise {k + 1}" for k in range(kf.n - plant.n)))
    return design_of_filter(kf, start, record, (states, plant.input_names, plant.output_names), page)
