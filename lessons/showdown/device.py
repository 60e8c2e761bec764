"""Give the controller on the stage of lesson 13 to a device."""

from __future__ import annotations

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, design_of_controller
from observer_lab.plants.platform import model
from observer_lab.plants.platform.lqg_weights import coils

from .controllers import DT, ORDER
from .study import Study

STEPS = 500
EDGE = 1 + 1e-6  # a pole on the plant's zero at s = 0 lies on the circle to rounding


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The controller that the knob `play` names, with its settled gains, in a loop with the platform after a blow. Raises DeviceError."""
    chosen = outcome.study.five[ORDER.index(outcome.design["play"])]
    plant = coils(model.plant())
    return design_of_controller(chosen.controller.last, plant, 0.01 * plant.B[:, 0], DT if ts is None else ts, STEPS, edge=EDGE)
