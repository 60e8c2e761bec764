"""Filters and loops over packets that can be lost or late."""

from .intermittent import (
    CriticalLoss,
    critical_loss,
    intermittent_covariances,
    intermittent_steps,
    lossy_growth,
    mare,
    mean_bounds,
    mean_lower_limit,
    measured,
    riccati_step,
    spectral_radius,
)
from .network_loop import delayed_loop, mean_square_growth
from .networked import NetworkRun, NetworkScenario, network_meter, promised_error, simulate_network
from .packets import Link, age_of

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
