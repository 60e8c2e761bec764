"""The plant, its transposed twin, and everything that is worked out on both sides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from app.engine import Plant, Scenario, lqe, lqr, observer_gain, place, simulate
from app.engine.structure import reachability_gramian
from app.lesson.lesson import Design
from app.plants import MODELS, Model, Window
from app.text.words import Text

from ..toolkit.knobs import BY_POLES
from .proofs import filter_riccati, observer_by_polynomial, output_energy

MODEL = MODELS["spring-damper"]
TINY = 1e-16


@dataclass(frozen=True, eq=False)
class Setting:
    """The plant of the lesson in a design, and what its weights and pictures are measured in.

    Q, R, W, V: the matrices that the four weights multiply. `pair`: two states that the ellipses show, with their axes.
    `window`: of both boards. `mirror`: whether velocities can be turned round.
    """

    model: Model
    plant: Callable[[Design], Plant]
    Q: np.ndarray
    R: np.ndarray
    W: np.ndarray
    V: np.ndarray
    pair: tuple[int, int]
    axes: tuple[Text | str, Text | str]
    window: Window
    mirror: bool = False


@dataclass(frozen=True, eq=False)
class Twins:
    """Both sides of each pair: the observer's own formula beside the controller of the transposed plant."""

    L: np.ndarray  # n×p, by the observer's own equation
    K_dual: np.ndarray  # p×n, feedback placed for (Aᵀ, Cᵀ)
    P: np.ndarray  # filter Riccati, own Hamiltonian
    S_dual: np.ndarray  # regulator Riccati of (Aᵀ, Cᵀ) with Q = W, R = V
    slowest: tuple[float, float]  # largest real part of the LQR's and of the LQE's poles
    reach: np.ndarray  # Gramian of (A, B) and the output energies of its dual
    reach_twin: np.ndarray
    seen: np.ndarray  # output energies of (A, C) and the Gramian of its dual
    seen_twin: np.ndarray
    t: np.ndarray  # the pairing, over the window of its own
    e: np.ndarray
    z: np.ndarray  # state of the dual loop, time reversed

    @property
    def pairing(self) -> np.ndarray:
        """x_d(T − t)ᵀ e(t), shape (n_t,): constant."""
        return np.sum(self.e * self.z, axis=1)


@lru_cache(maxsize=128)
def turned(degrees: float) -> Plant:
    """The spring-damper with its sensor turned from position (0°) to velocity (90°)."""
    angle, p = np.radians(degrees), MODEL.plant
    C = np.array([[np.cos(angle), np.sin(angle)]])
    C[np.abs(C) < TINY] = 0.0
    names = "position" if degrees == 0 else "velocity" if degrees == 90 else "sensor"
    return Plant(p.A, p.B, C, p.D, 0.0, p.state_names, p.input_names, (names,), p.units[:3], p.name)


def weights_of(here: Setting, design: Design) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Q, R of the regulator and W, V of the filter."""
    q, r = design["q"], design["r"]
    w, v = (q, r) if design["mirror"] else (design["w"], design["v"])
    return q * here.Q, r * here.R, w * here.W, v * here.V


def gains_of(here: Setting, design: Design, plant: Plant) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """K of the plant, L by the engine, L by the observer's own equation, K_d of the transposed plant."""
    A, B, C = plant.A, plant.B, plant.C
    Q, R, W, V = weights_of(here, design)
    if design["method"] == BY_POLES:
        p = design["poles"]
        return (place(A, B, p).gain, observer_gain(A, C, p).gain, observer_by_polynomial(A, C, p),
                place(A.T, C.T, p).gain)
    own = np.linalg.solve(V, C @ filter_riccati(A, C, W, V)).T
    return lqr(A, B, Q, R).gain, lqe(A, np.eye(plant.n), C, W, V).gain, own, lqr(A.T, C.T, W, V).gain


def run_pair(model: Model, plant: Plant, L: np.ndarray, K_dual: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """e(t) of the observer and x_d(T − t) of the dual loop over a window of about two of the slowest time constants."""
    slowest = float(np.min(np.abs(np.linalg.eigvals(plant.A - L @ plant.C).real)))
    span = float(np.clip(2 / max(slowest, 1e-6 / model.horizon), model.horizon / 24, model.horizon / 3))
    step = span / 200
    seen = simulate(Scenario(plant, L=L, x0=model.x0, xhat0=model.guess, horizon=span, dt=step))
    dual = simulate(Scenario(plant.dual(), K_dual, x0=np.ones(plant.n), horizon=span, dt=step, state_feedback=True))
    count = min(len(seen.t), len(dual.t))
    return seen.t[:count], seen.e[:count], dual.x[:count][::-1]


def twins_of(here: Setting, design: Design, plant: Plant, own: np.ndarray, K_dual: np.ndarray) -> Twins:
    """Each pair worked out on both sides, with L and K_d given."""
    A, B, C = plant.A, plant.B, plant.C
    Q, R, W, V = weights_of(here, design)
    regulator, twin = lqr(A, B, Q, R), lqr(A.T, C.T, W, V)
    return Twins(
        own, K_dual, filter_riccati(A, C, W, V), twin.solution,
        (float(max(regulator.poles.real)), float(max(twin.poles.real))),
        *_gramians(plant, design["window"]), *run_pair(here.model, plant, own, K_dual))


@lru_cache(maxsize=128)
def _gramians(plant: Plant, T: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Reached by (A, B), heard by (Aᵀ, Bᵀ); heard by (A, C), reached by (Aᵀ, Cᵀ); 2×2 each, within T seconds."""
    A, B, C = plant.A, plant.B, plant.C
    return (reachability_gramian(plant, T), output_energy(A.T, B.T, T),
            output_energy(A, C, T), reachability_gramian(plant.dual(), T))


def gap(a: np.ndarray, b: np.ndarray) -> float:
    """max|a − b| relative to max|b|."""
    return float(np.max(np.abs(a - b)) / max(np.max(np.abs(b)), TINY))
