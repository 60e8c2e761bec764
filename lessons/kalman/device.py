"""Give the filter of lesson 9 to a device, on the deck or on an own plant."""

from __future__ import annotations

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, DeviceError, design_of_filter
from observer_lab.text import text

from .knobs import MODEL
from .own_study import OwnStudy
from .study import Study

ONE_PERIOD = text("This filter is made for its own period of {dt:.6g} s; leave the period out.")


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The filter on the record that the page shows. Raises DeviceError for another period."""
    study = outcome.study
    kf, plant = study.watcher.filter, study.found.run.scenario.plant if isinstance(study, OwnStudy) else MODEL.plant
    if ts is not None and abs(ts - kf.dt) > 1e-9 * kf.dt:
        raise DeviceError(ONE_PERIOD.format(dt=kf.dt))
    states = (*plant.state_names, *(f"noise {k + 1}" for k in range(kf.n - plant.n)))
    return design_of_filter(kf, study.watcher.start, (study.truth.y, study.truth.u), (states, plant.input_names, plant.output_names),
                            study.track.means)
