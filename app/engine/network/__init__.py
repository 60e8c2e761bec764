"""Filters and loops over packets that can be lost or late."""

from .door import (
    age_of,
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
    promised_error,
    riccati_step,
    simulate_network,
    spectral_radius,
)
from .intermittent import CriticalLoss
from .networked import NetworkRun, NetworkScenario
from .packets import Link

__all__ = [
    "CriticalLoss",
    "Link",
    "NetworkRun",
    "NetworkScenario",
    "age_of",
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
    "promised_error",
    "riccati_step",
    "simulate_network",
    "spectral_radius",
]
