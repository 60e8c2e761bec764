"""Runs of a loop: scenarios, disturbances, saturation, batches and maps of recovery."""

from .batch import march_starts
from .loop import emulated_gain
from .recovery import RecoveryMap, recovery_map, starts_of
from .scenario import Run, Scenario
from .simulate import autonomous_error, separation_meter, simulate

__all__ = [
    "RecoveryMap",
    "Run",
    "Scenario",
    "autonomous_error",
    "emulated_gain",
    "march_starts",
    "recovery_map",
    "separation_meter",
    "simulate",
    "starts_of",
]
