"""Design LQG on ten states and on fewer, both closed around the ten states."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.course.lazy import LazyValue
from observer_lab.engine import Plant, lqg, noisy_loop
from observer_lab.engine.feedback import Lqg, NoisyLoop
from observer_lab.plants.platform.lqg_weights import FIGURE_V, Weights, coils, ground
from observer_lab.text import text

from .balanced_platform import STATE_COUNT, Platform

WEIGHT_OUTPUTS, STATES_ALIKE = "outputs", "alike"
PRESSED = ((WEIGHT_OUTPUTS, text("the four outputs")), (STATES_ALIKE, text("every balanced state alike")))
EQUAL = 1e10  # weight of each balanced state where all count alike
PAIRS = STATE_COUNT // 2
AXIS_POLE_RAD_S = 1e-9  # rad/s: a pole no farther left is on the axis to rounding, and its variance is not to be told


@dataclass(frozen=True, eq=False)
class Loop:
    """One design on a balanced model, closed around the ten states: gains by pair (5,), densities, cost, force.

    densities (n_f, 4) of the outputs in (m/s)²/Hz, None where the loop is unstable or on the edge. rightmost: real part of the slowest
    pole. spent: the averages of xᵀQx and uᵀRu where there are such; alpha: R of one newton.
    """

    design: Lqg
    K: np.ndarray
    L: np.ndarray
    rightmost: float
    densities: np.ndarray | None
    spent: LazyValue[tuple[float, float]] | None
    alpha: float

    @property
    def cost(self) -> float | None:
        """The average of xᵀQx + uᵀRu."""
        return None if self.spent is None else sum(self.spent.value)

    @property
    def force(self) -> float | None:
        """Rms of all coils in N."""
        return None if self.spent is None else float(np.sqrt(self.spent.value[1] / self.alpha))

    @property
    def stable(self) -> bool:
        """Whether the loop with the ten-state platform is stable."""
        return self.densities is not None


@dataclass(frozen=True, eq=False)
class Compared:
    """The design on ten states and the one on fewer, and the densities without control."""

    free: np.ndarray
    full: Loop
    small: Loop

    @property
    def gap(self) -> float | None:
        """Largest relative difference between their densities, over the outputs and over frequency."""
        if self.small.densities is None or self.full.densities is None:
            return None
        return float(np.abs(self.small.densities / self.full.densities - 1).max())

    @property
    def extra(self) -> float | None:
        """Cost of the small design on the platform over that of the full one, less one."""
        if self.small.cost is None or self.full.cost is None:
            return None
        return self.small.cost / self.full.cost - 1

    @property
    def growth(self) -> float:
        """How much larger ‖K‖ is on ten states than on fewer."""
        return float(np.linalg.norm(self.full.design.K) / np.linalg.norm(self.small.design.K)) - 1


@lru_cache(maxsize=32)
def _on(s: Platform, order: int, v0: float, pressed: str) -> Loop:
    weights = weights_of(s, v0)
    small = s.reduced(order)[0]
    Q = weights.Q(small) if pressed == WEIGHT_OUTPUTS else EQUAL * np.eye(order)
    design = lqg(coils(small), Q, weights.R, weights.W, weights.V, G=ground(small))
    K, L = by_pair(design.K), by_pair(design.L.T)
    loop = _closed(s, design.controller, weights)
    rightmost = float(loop.poles.real.max())
    if rightmost > -AXIS_POLE_RAD_S:
        return Loop(design, K, L, rightmost, None, None, weights.alpha_r)
    paid = weights.Q(s.plant) if pressed == WEIGHT_OUTPUTS else EQUAL * s.balanced.left.T @ s.balanced.left
    return Loop(design, K, L, rightmost, loop.psd(s.frequencies), LazyValue(lambda: loop.cost(paid, weights.R)), weights.alpha_r)


def weights_of(s: Platform, v0: float = FIGURE_V) -> Weights:
    """The report's weights; the ground's intensity in the square of the unit in which it is counted."""
    return Weights(v0=v0, beta_q=1 / s.unit**2)


@lru_cache(maxsize=32)
def _free(s: Platform) -> np.ndarray:
    weights = weights_of(s)
    return noisy_loop(coils(s.plant), None, ground(s.plant), weights.W).psd(s.frequencies)


def compare(s: Platform, order: int, v0: float, pressed: str) -> Compared:
    """Both designs for measurement noise of intensity v0 in (m/s)² s, Q from the outputs or from every balanced state."""
    return Compared(_free(s), _on(s, STATE_COUNT, v0, pressed), _on(s, order, v0, pressed))


def by_pair(gain: np.ndarray) -> np.ndarray:
    """Norm of the columns of a gain by pairs of balanced states, (5,), zero for pairs that the model has not."""
    squares = np.zeros(STATE_COUNT)
    squares[:gain.shape[1]] = (gain**2).sum(axis=0)
    return np.sqrt(squares.reshape(PAIRS, 2).sum(axis=1))


def _closed(s: Platform, controller: Plant, weights: Weights) -> NoisyLoop:
    return noisy_loop(coils(s.plant), controller, ground(s.plant), weights.W, V=weights.V)
