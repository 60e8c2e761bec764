"""Discretise a plant by the zero-order hold or by Tustin's rule, and invert both."""

from __future__ import annotations

import warnings

import numpy as np
from scipy.linalg import expm, logm

from .balance import balance
from .errors import EngineError
from .gates.argument_checks import SECONDS, takes
from .gates.plant_gate import PLANT
from .plant import Plant
from .recursions import LARGE, driven_step, step_by_doubling

__all__ = ["continuous_of", "discretise", "from_tustin", "require_continuous", "tustin"]

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
    if plant.n >= LARGE:
        Phi, Gamma = step_by_doubling(plant.A, plant.B, dt)
    else:
        own = balance(plant.A, plant.B)  # the exponential loses digits where states are in unlike units
        x = own.states
        Phi, Gamma = driven_step(own.A(plant.A), own.B(plant.B), dt)
        Phi, Gamma = Phi * x[:, None] / x, Gamma * x[:, None] / own.inputs
    return _with_matrices(plant, Phi, Gamma, plant.C, np.asarray(plant.D), dt)


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
    like = balance(plant.A, plant.B)
    wide = np.eye(n + m)
    wide[:n, :n], wide[:n, n:] = like.A(plant.A), like.B(plant.B)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        root = np.asarray(logm(wide), dtype=complex) / dt
    scale = max(float(np.abs(root).max()), 1e-300) if np.all(np.isfinite(root)) else np.inf
    M = np.real(root)
    if not np.isfinite(scale) or np.abs(np.imag(root)).max() > 1e-8 * scale or _miss(M, wide, dt) > ROUND_TRIP:
        raise EngineError("No continuous plant could be found behind this sampled one: its logarithm is lost in "
                          "rounding.")
    x, u = like.states, like.inputs
    return _with_matrices(plant, M[:n, :n] * x[:, None] / x, M[:n, n:] * x[:, None] / u, plant.C, np.asarray(plant.D), 0.0)


@takes(plant=PLANT, dt=SECONDS)
def tustin(plant: Plant, dt: float) -> Plant:
    """The plant with s = 2(z − 1)/(dt (z + 1)): A_d = S (I + A dt/2), B_d = S B dt, C_d = C S, S = (I − A dt/2)⁻¹, D_d = D + C S B dt/2.

    Raises EngineError for a plant that is sampled already, and for a pole at 2/dt.
    """
    require_continuous(plant)
    half = plant.A * (dt / 2)
    S = _inverse(np.eye(plant.n) - half, EngineError("The plant has a pole at 2/dt = {dt:g} rad/s, which Tustin's rule sends to infinity; "
                                                     "choose another period.", dt=2 / dt))
    return _with_matrices(plant, S @ (np.eye(plant.n) + half), S @ plant.B * dt, plant.C @ S,
                          np.asarray(plant.D) + plant.C @ S @ plant.B * (dt / 2), dt)


@takes(plant=PLANT)
def from_tustin(plant: Plant) -> Plant:
    """The continuous plant whose `tustin` is this one. Raises EngineError for a pole at −1, and for a plant that is continuous."""
    if not plant.dt:
        raise EngineError("This plant is continuous already.")
    dt = plant.dt
    back = _inverse((np.eye(plant.n) + plant.A) / 2, EngineError("This sampled plant has a pole at −1, which Tustin's rule has from no "
                                                                 "continuous plant."))
    return _with_matrices(plant, (np.eye(plant.n) - back) * (2 / dt), back @ plant.B / dt, plant.C @ back,
                          np.asarray(plant.D) - plant.C @ back @ plant.B / 2, 0.0)


def _inverse(M: np.ndarray, refusal: EngineError) -> np.ndarray:
    """M⁻¹, or the refusal where its smallest singular value is rounding."""
    values = np.linalg.svd(M, compute_uv=False)
    if values.size and values[-1] <= 1e-14 * values[0]:
        raise refusal
    return np.linalg.inv(M)


def _with_matrices(plant: Plant, A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray, dt: float) -> Plant:
    return Plant(A, B, C, D, dt, plant.state_names, plant.input_names, plant.output_names, plant.units, plant.name, plant.notes)


def _miss(M: np.ndarray, sampled: np.ndarray, dt: float) -> float:
    with np.errstate(all="ignore"):
        back = expm(M * dt)
    return float(np.abs(back - sampled).max() / np.abs(sampled).max()) if np.all(np.isfinite(back)) else np.inf
