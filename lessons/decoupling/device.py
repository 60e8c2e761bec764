"""Give the three controllers of lesson 11, with their mixing, to a device."""

from __future__ import annotations

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, design_of_controller
from observer_lab.plants.platform.lqg_weights import coils

from .loops import PLATFORM_PLANT, STATE_JUMP
from .study import Study

PERIOD_S, STEPS = 2e-5, 500  # s: the published pair has gains that a slower computer cannot hold
EDGE = 1 + 1e-6  # a pole of C_v on the plant's zero at s = 0 lies on the circle to rounding


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """All channels as one controller from y to u, in a loop with the platform after a kick. Raises DeviceError."""
    plant = coils(PLATFORM_PLANT)
    return design_of_controller(outcome.study.controllers.whole, plant, STATE_JUMP, PERIOD_S if ts is None else ts, STEPS, edge=EDGE)
