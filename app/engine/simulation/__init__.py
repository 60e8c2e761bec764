"""Simulate loops: scenarios, disturbances, saturation, batches, recovery maps."""

from ..systems.gates.room_gates import with_gates
from .batch import simulate_starts
from .geared import Gear, GearedRun, simulate_geared
from .loop import emulated_gain
from .recovery import RecoveryMap, simulate_recovery, starts_of
from .scenario import Run, Scenario
from .simulate import autonomous_error, disturbances_of, separation_meter, simulate, simulate_until

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

with_gates(globals())
