"""Runs of a loop: scenarios, disturbances, saturation, batches and maps of recovery."""

from .batch import simulate_starts
from .loop import emulated_gain
from .recovery import RecoveryMap, simulate_recovery, starts_of
from .scenario import Run, Scenario
from .simulate import autonomous_error, separation_meter, simulate

__all__ = [
    "RecoveryMap",
    "Run",
    "Scenario",
    "autonomous_error",
    "emulated_gain",
    "separation_meter",
    "simulate",
    "simulate_recovery",
    "simulate_starts",
    "starts_of",
]
