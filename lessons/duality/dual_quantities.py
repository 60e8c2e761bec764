"""Compute each quantity of lesson 5 twice: by the observer's formula and by its dual."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm, schur

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import RUN_LOST, Design
from observer_lab.engine import EngineError, Plant, Scenario, lqe, lqr, observer_gain, place, simulate
from observer_lab.engine.design import Optimal
from observer_lab.engine.structure import reachability_gramian
from observer_lab.engine.systems import state_scale, symmetric
from observer_lab.plants import Model, Window
from observer_lab.text import Text

from ..toolkit.knobs import BY_POLES
from .finite_horizon import Horizon, Weights, horizon_of

FLIP = np.diag([1.0, -1.0])  # the mirror that turns velocities round
TINY = 1e-16
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(48)


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


class Energies(NamedTuple):
    """What is reached and heard within a window, n×n each: reached by (A, B) and heard by (Aᵀ, Bᵀ); heard by (A, C) and reached by
    (Aᵀ, Cᵀ)."""

    reach: np.ndarray
    reach_twin: np.ndarray
    seen: np.ndarray
    seen_twin: np.ndarray


class Pair(NamedTuple):
    """A run of both loops: instants t (n_t,), the observer's error e (n_t, n), the state z of the dual loop, time reversed (n_t, n)."""

    t: np.ndarray
    e: np.ndarray
    z: np.ndarray


@dataclass(frozen=True, eq=False)
class Twins:
    """Both sides of each pair, found when they are looked at: the observer's own formula beside the controller of the transposed plant.

    Raises what the formula raises that is looked at.
    """

    here: Setting
    design: Design
    plant: Plant

    @cached_property
    def weights(self) -> Weights:
        """Q, R of the regulator and W, V of the filter."""
        return weights_of(self.here, self.design)

    @cached_property
    def regulator(self) -> Optimal:
        """Of (A, B) with Q, R."""
        return lqr(self.plant.A, self.plant.B, *self.weights[:2])

    @cached_property
    def twin(self) -> Optimal:
        """The regulator of (Aᵀ, Cᵀ) with Q = W, R = V."""
        return lqr(self.plant.A.T, self.plant.C.T, *self.weights[2:])

    @cached_property
    def P(self) -> np.ndarray:
        """Of the filter's Riccati equation, by its own Hamiltonian."""
        return filter_riccati(self.plant.A, self.plant.C, *self.weights[2:])

    @cached_property
    def K(self) -> np.ndarray:
        """The gain of the plant (m×n)."""
        return place(self.plant.A, self.plant.B, self.design["poles"]).gain if self._placed else self.regulator.gain

    @cached_property
    def L(self) -> np.ndarray:
        """The observer's gain (n×p) by its own equation."""
        A, C, V = self.plant.A, self.plant.C, self.weights[3]
        return observer_by_polynomial(A, C, self.design["poles"]) if self._placed else np.linalg.solve(V, C @ self.P).T

    @cached_property
    def L_engine(self) -> np.ndarray:
        """The same by the engine."""
        A, C, n = self.plant.A, self.plant.C, self.plant.n
        return observer_gain(A, C, self.design["poles"]).gain if self._placed else lqe(A, np.eye(n), C, *self.weights[2:]).gain

    @cached_property
    def K_dual(self) -> np.ndarray:
        """The feedback of (Aᵀ, Cᵀ) (p×n)."""
        return place(self.plant.A.T, self.plant.C.T, self.design["poles"]).gain if self._placed else self.twin.gain

    @property
    def _placed(self) -> bool:
        return self.design["method"] == BY_POLES

    @property
    def S(self) -> np.ndarray:
        """Of the regulator."""
        return self.regulator.solution

    @property
    def S_dual(self) -> np.ndarray:
        """Of its twin."""
        return self.twin.solution

    @property
    def slowest(self) -> tuple[float, float]:
        """The largest real part of the LQR's and of the LQE's poles."""
        return float(max(self.regulator.poles.real)), float(max(self.twin.poles.real))

    @property
    def energies(self) -> Energies:
        """What both pairs reach and hear within the window."""
        return _gramians(self.plant, self.design["window"])

    @cached_property
    def horizon(self) -> Horizon:
        """Both equations in time, over the window, from shares of what they settle to."""
        share = self.design["terminal"]
        return horizon_of(self.plant, self.weights, self.S, self.P, self.design["window"], (share * self.S, share * self.P))

    @cached_property
    def pair(self) -> Pair:
        """The pairing over a window of its own."""
        return run_pair(self.here.model, self.plant, self.L, self.K_dual)

    @property
    def pairing(self) -> np.ndarray:
        """x_d(T − t)ᵀ e(t), shape (n_t,): constant."""
        return np.sum(self.pair.e * self.pair.z, axis=1)

    @property
    def pairing_gap(self) -> float:
        """How far it is from that, relative to the size of its factors."""
        size = float(np.max(np.linalg.norm(self.pair.e, axis=1) * np.linalg.norm(self.pair.z, axis=1)))
        return float(np.ptp(self.pairing)) / max(size, TINY)

    @property
    def mirror_gap(self) -> float:
        """How far the two ellipses are from mirror images, 1 where velocities cannot be turned round."""
        return gap(FLIP @ self.energies.reach @ FLIP, self.energies.seen) if self.here.mirror else 1.0


def gap(a: np.ndarray, b: np.ndarray) -> float:
    """max|a − b| relative to max|b|."""
    return float(np.max(np.abs(a - b)) / max(np.max(np.abs(b)), TINY))


def weights_of(here: Setting, design: Design) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Q, R of the regulator and W, V of the filter."""
    q, r = design["q"], design["r"]
    w, v = (q, r) if design["mirror"] else (design["w"], design["v"])
    return q * here.Q, r * here.R, w * here.W, v * here.V


def run_pair(model: Model, plant: Plant, L: np.ndarray, K_dual: np.ndarray) -> Pair:
    """e(t) of the observer and x_d(T − t) of the dual loop over a window of about two of the slowest time constants.

    Raises KnobError where one of them is lost within its first step.
    """
    slowest = float(np.min(np.abs(np.linalg.eigvals(plant.A - L @ plant.C).real)))
    span = float(np.clip(2 / max(slowest, 1e-6 / model.horizon), model.horizon / 24, model.horizon / 3))
    step = span / 200
    seen = simulate(Scenario(plant, L=L, x0=model.x0, xhat0=model.guess, horizon=span, dt=step))
    dual = simulate(Scenario(plant.dual(), K_dual, x0=np.ones(plant.n), horizon=span, dt=step, state_feedback=True))
    count = min(len(seen.t), len(dual.t))
    if count < 2:
        raise KnobError(RUN_LOST)
    return Pair(seen.t[:count], seen.e[:count], dual.x[:count][::-1])


@lru_cache(maxsize=128)
def _gramians(plant: Plant, T: float) -> Energies:
    """Within T seconds: each pair's own by its own formula, its twin's by the other one."""
    A, B, C = plant.A, plant.B, plant.C
    return Energies(reachability_gramian(plant, T), output_energy(A.T, B.T, T),
                    output_energy(A, C, T), reachability_gramian(plant.dual(), T))


def observer_by_polynomial(A: np.ndarray, C: np.ndarray, poles: Sequence[complex]) -> np.ndarray:
    """L (n×1) = φ(A) O⁻¹ (0 … 0 1)ᵀ with φ the polynomial of the poles asked: Ackermann's formula for one output.

    A n×n, C 1×n. Raises EngineError where O = [C; CA; …] is singular.
    """
    rows = [C]
    for _ in range(len(A) - 1):
        rows.append(rows[-1] @ A)
    try:
        last = np.linalg.solve(np.vstack(rows), np.eye(len(A))[:, -1:])
    except np.linalg.LinAlgError:
        raise EngineError("This sensor does not see every state, so the formula for L fails; turn the sensor.") from None
    phi = np.zeros_like(A)
    for coefficient in np.real(np.poly(np.asarray(poles))):
        phi = phi @ A + coefficient * np.eye(len(A))
    return phi @ last


def filter_riccati(A: np.ndarray, C: np.ndarray, W: np.ndarray, V: np.ndarray) -> np.ndarray:
    """P (n×n) of AP + PAᵀ − PCᵀV⁻¹CP + W = 0 from the filter's own Hamiltonian [−Aᵀ CᵀV⁻¹C; W A].

    The Hamiltonian's unstable invariant subspace is spanned by [I; P], in balanced states. A n×n, C p×n, W n×n ⪰ 0, V p×p > 0.
    Raises EngineError where rounding leaves no such subspace.
    Source: Laub, "A Schur method for solving algebraic Riccati equations" (1979), written for the filter.
    """
    n, scale = len(A), state_scale(A, None, C)
    A, C, W = A * scale / scale[:, None], C * scale, W / scale / scale[:, None]
    try:
        basis = schur(np.block([[-A.T, C.T @ np.linalg.solve(V, C)], [W, A]]), output="real", sort="rhp")[1][:, :n]
        P = np.linalg.solve(basis[:n].T, basis[n:].T).T
    except np.linalg.LinAlgError:
        raise EngineError("The Riccati equation is too ill-conditioned to be solved; bring the weights or the units of the "
                          "states closer.") from None
    return scale[:, None] * symmetric(P) * scale


def output_energy(A: np.ndarray, C: np.ndarray, horizon: float) -> np.ndarray:
    """E (n×n): E_ij = ∫₀ᵀ y_i(t)·y_j(t) dt, y_i the output after a start at the i-th unit state. Gauss quadrature.

    x(0)ᵀ E x(0) is the energy that the start x(0) leaves in the measurement within T seconds.
    """
    t = (GAUSS_NODES + 1) * horizon / 2
    y = C @ expm(t[:, None, None] * A)  # (48, p, n)
    return np.einsum("k,kpi,kpj->ij", GAUSS_WEIGHTS * horizon / 2, y, y)
