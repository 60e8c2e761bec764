"""Simulate loops: scenarios, disturbances, saturation, batches, recovery maps."""

from .door import (
    autonomous_error,
    disturbances_of,
    emulated_gain,
    separation_meter,
    simulate,
    simulate_geared,
    simulate_recovery,
    simulate_starts,
    simulate_until,
    starts_of,
)
from .geared import Gear, GearedRun
from .recovery import RecoveryMap
from .scenario import Run, Scenario

__all__ = [
    "Gear",
    "GearedRun",
    "RecoveryMap",
    "Run",
    "Scenario",
    "autonomous_error",
    "disturbances_of",
    "emulated_gain",
    "separation_meter",
    "simulate",
    "simulate_geared",
    "simulate_recovery",
    "simulate_starts",
    "simulate_until",
    "starts_of",
]
