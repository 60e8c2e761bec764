"""Give the LQG of lesson 12, designed on fewer states, to a device."""

from __future__ import annotations

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, DeviceError, design_of_controller
from observer_lab.plants.platform.lqg_weights import coils
from observer_lab.text import text

from .platform_study import PlatformStudy
from .study import Study

PERIOD_S, STEPS = 0.001, 500
NO_LOOP = text("On your own plant this lesson designs no controller; use the lesson lqg for one.")


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The controller on the cut model, in a loop with the whole platform after a blow on its first coil. Raises DeviceError."""
    study = outcome.study
    if not isinstance(study, PlatformStudy):
        raise DeviceError(NO_LOOP)
    plant = coils(study.system.plant)
    return design_of_controller(study.compared.small.design.controller, plant, plant.B[:, 0], PERIOD_S if ts is None else ts, STEPS)
