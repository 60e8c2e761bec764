"""Discretise a plant by the zero-order hold, and invert it."""

from __future__ import annotations

import warnings

import numpy as np
from scipy.linalg import expm, logm

from .errors import EngineError
from .gates.argument_checks import SECONDS, takes
from .gates.plant_gate import PLANT
from .plant import Plant
from .recursions import step_matrices

__all__ = ["continuous_of", "discretise", "require_continuous"]

ROUND_TRIP = 1e-7  # how well e^{M dt} must give back what was sampled, relative to its size


def require_continuous(plant: Plant) -> None:
    """EngineError where the plant has a sampling period, which a call for continuous plants would ignore."""
    if plant.dt:
        raise EngineError("The plant is sampled already; give the continuous one.")


@takes(plant=PLANT, dt=SECONDS)
def discretise(plant: Plant, dt: float) -> Plant:
    """The plant seen every dt seconds with its input held: A_d = e^{A dt}, B_d = ∫₀ᵈᵗ e^{A s} ds B.

    Raises EngineError for a plant that is sampled already.
    """
    require_continuous(plant)
    Phi, Phi1 = step_matrices(plant.A, dt)
    return Plant(Phi, Phi1 @ plant.B, plant.C, plant.D, dt, plant.state_names, plant.input_names,
                 plant.output_names, plant.units, plant.name, plant.notes)


@takes(plant=PLANT)
def continuous_of(plant: Plant) -> Plant:
    """The continuous plant that, its input held over dt, is this one at the samples; itself where dt = 0.

    [A_d B_d; 0 I] = exp([A B; 0 0] dt), so A, B come from the principal logarithm; C and D stay. n×n, n×m as before.
    Raises EngineError where no such real plant exists: a pole at zero or on the negative real axis, or rounding.
    """
    if not plant.dt:
        return plant
    n, m, dt = plant.n, plant.m, plant.dt
    size = max(float(np.abs(plant.poles).max(initial=0.0)), 1.0)
    for pole in plant.poles:
        if abs(pole) < 1e-9 * size:
            raise EngineError("This sampled plant has a pole at zero (a delay), which no continuous plant has.")
        if pole.real < 0 and abs(pole.imag) < 1e-9 * size:
            raise EngineError("This sampled plant has a pole at {pole_real:.4g}: on the negative real axis no "
                              "pole comes from a continuous plant of the same order.",
                              pole_real=pole.real)
    wide = np.eye(n + m)
    wide[:n, :n], wide[:n, n:] = plant.A, plant.B
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        root = np.asarray(logm(wide), dtype=complex) / dt
    scale = max(float(np.abs(root).max()), 1e-300) if np.all(np.isfinite(root)) else np.inf
    M = np.real(root)
    if not np.isfinite(scale) or np.abs(np.imag(root)).max() > 1e-8 * scale or _miss(M, wide, dt) > ROUND_TRIP:
        raise EngineError("No continuous plant could be found behind this sampled one: its logarithm is lost in "
                          "rounding.")
    return Plant(M[:n, :n], M[:n, n:], plant.C, plant.D, 0.0, plant.state_names, plant.input_names, plant.output_names,
                 plant.units, plant.name, plant.notes)


def _miss(M: np.ndarray, sampled: np.ndarray, dt: float) -> float:
    with np.errstate(all="ignore"):
        back = expm(M * dt)
    return float(np.abs(back - sampled).max() / np.abs(sampled).max()) if np.all(np.isfinite(back)) else np.inf
