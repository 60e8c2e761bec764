"""Analyse filters and loops over packets that can be lost or late."""

from .door import (
    critical_loss,
    delayed_loop,
    intermittent_covariances,
    intermittent_steps,
    lossy_growth,
    mare,
    mean_bounds,
    mean_lower_limit,
    mean_square_growth,
    measured,
    network_meter,
    newest_packet_age,
    promised_error,
    riccati_step,
    simulate_network,
    spectral_radius,
)
from .intermittent import CriticalLoss
from .network_simulation import NetworkRun, NetworkScenario
from .packets import Link

__all__ = [
    "CriticalLoss",
    "Link",
    "NetworkRun",
    "NetworkScenario",
    "critical_loss",
    "delayed_loop",
    "intermittent_covariances",
    "intermittent_steps",
    "lossy_growth",
    "mare",
    "mean_bounds",
    "mean_lower_limit",
    "mean_square_growth",
    "measured",
    "network_meter",
    "newest_packet_age",
    "promised_error",
    "riccati_step",
    "simulate_network",
    "spectral_radius",
]
