"""Analyse filters and loops over packets that can be lost or late."""

from ..systems.gates.room_gates import with_gates
from .intermittent import (
    CriticalLoss,
    corrected_covariance,
    critical_loss,
    intermittent_covariances,
    intermittent_steps,
    lossy_growth,
    mare,
    mean_bounds,
    mean_lower_limit,
    riccati_step,
    spectral_radius,
)
from .network_loop import delayed_loop, mean_square_growth
from .network_simulation import NetworkRun, NetworkScenario, network_meter, promised_error, simulate_network
from .packets import Link, newest_packet_age

__all__ = [
    "CriticalLoss",
    "Link",
    "NetworkRun",
    "NetworkScenario",
    "corrected_covariance",
    "critical_loss",
    "delayed_loop",
    "intermittent_covariances",
    "intermittent_steps",
    "lossy_growth",
    "mare",
    "mean_bounds",
    "mean_lower_limit",
    "mean_square_growth",
    "network_meter",
    "newest_packet_age",
    "promised_error",
    "riccati_step",
    "simulate_network",
    "spectral_radius",
]

with_gates(globals())
