"""Balance the user's own plant for lesson 12: Hankel values, truncations, one blow on plant and model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import expm

from observer_lab.course.knobs import KnobError
from observer_lab.engine import EngineError, Plant, balanced_truncation, frequency_response
from observer_lab.engine.design import typical_rate
from observer_lab.engine.structure import Truncation, split_stable
from observer_lab.plants import Model
from observer_lab.text import text

from .balanced_platform import Cut, sharp_bound
from .study import Ranks, ranks_of

GOOD_SHARE = 0.01  # of σ₁: the order at the start is the least whose bound 2Σσ is below it
MAX_GROWTH_EXPONENT = 5.0  # how many times e a run may grow
SAMPLES = 240  # of a run


@dataclass(frozen=True, eq=False)
class OwnSystem:
    """A plant and its balanced states: `whole` keeps all that take part between u and y, the unstable ones last."""

    model: Model
    whole: Truncation

    @property
    def plant(self) -> Plant:
        """The plant as it came."""
        return self.model.plant

    @property
    def hankel(self) -> np.ndarray:
        """The Hankel values of its stable part, largest first."""
        return self.whole.hankel

    @property
    def least(self) -> int:
        """The unstable states, which no model may leave out; one state at the least."""
        return max(self.whole.kept, 1)

    @property
    def most(self) -> int:
        """How many states take part between u and y."""
        return self.whole.plant.n

    @cached_property
    def frequencies(self) -> np.ndarray:
        """Hz: two decades to both sides of all modes that move, denser about each."""
        poles = self.plant.poles
        speeds = np.abs(poles)[np.abs(poles) > 1e-7 * max(np.abs(poles).max(), 1e-300)]
        speeds = speeds if speeds.size else np.array([typical_rate(self.plant)])
        about = np.outer(speeds, np.linspace(0.9, 1.1, 9)).ravel()
        return np.unique(np.concatenate([np.geomspace(speeds.min() / 100, 100 * speeds.max(), 120), about])) / (2 * np.pi)

    @cached_property
    def response(self) -> np.ndarray:
        """G(j2πf)."""
        return heard(self.plant, self.frequencies)

    @cached_property
    def good(self) -> int:
        """The least order whose bound is below a hundredth of the largest Hankel value."""
        tail = 2 * np.append(np.cumsum(self.hankel[::-1])[::-1], 0.0)
        fine = int(np.argmax(tail <= GOOD_SHARE * self.hankel[0]))
        return min(max(self.whole.kept + fine, self.least), self.most)


@dataclass(frozen=True, eq=False)
class OwnStudy:
    """Ranks with time in units of `clock`, a cut to `order` states, and one blow on both. Each is found when it is looked at."""

    system: OwnSystem
    clock: float
    order: int

    @cached_property
    def ranks(self) -> Ranks:
        """Singular values of both matrices; the states stay in the units given."""
        return _ranks(self.system, self.clock)

    @cached_property
    def cut(self) -> Cut:
        """The truncation and its error."""
        return cut(self.system, self.order)

    @cached_property
    def truncation(self) -> Truncation:
        """The truncation with its two transformations."""
        return _truncation(self.system, self.order)

    @cached_property
    def blow(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """t (k,), states of the plant (k×n) after a blow on its first input, and those of the model, T z (k×n)."""
        return blow(self.system, self.order)


def heard(plant: Plant, f: np.ndarray) -> np.ndarray:
    """G(j2πf), a matrix for each f in Hz; a pole on the axis is passed beside it."""
    with np.errstate(all="ignore"):
        return frequency_response(plant.A, plant.B, plant.C, np.asarray(plant.D), 2 * np.pi * f)


@lru_cache(maxsize=64)
def _ranks(s: OwnSystem, clock: float) -> Ranks:
    P = s.plant
    return ranks_of(Plant(clock * P.A, clock * P.B, P.C, P.D), clock)


@lru_cache(maxsize=64)
def _truncation(s: OwnSystem, order: int) -> Truncation:
    return s.whole if order == s.most else balanced_truncation(s.plant, order)


@lru_cache(maxsize=64)
def cut(s: OwnSystem, order: int) -> Cut:
    """The truncation to `order` states, its error over frequency, and both bounds."""
    small, stable = _truncation(s, order), order - s.whole.kept
    gap = s.response - heard(small.plant, s.frequencies)
    error = np.linalg.norm(np.where(np.isfinite(gap), gap, 0.0), 2, axis=(1, 2))
    at = int(error.argmax())
    return Cut(order, small.plant, error, float(error[at]), float(s.frequencies[at]), small.error_bound, sharp_bound(s.hankel, stable))


def blow(s: OwnSystem, order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Both run free from the same blow: x(0) = kick, z(0) = left x(0)."""
    small = _truncation(s, order)
    fastest = float(np.real(s.plant.poles).max())
    t = np.linspace(0.0, min(s.model.horizon, MAX_GROWTH_EXPONENT / fastest) if fastest > 0 else s.model.horizon, SAMPLES + 1)
    start = np.asarray(s.model.kick)
    return t, _free(s.plant.A, start, t[1], SAMPLES), _free(small.plant.A, small.left @ start, t[1], SAMPLES) @ small.T.T


def _free(A: np.ndarray, start: np.ndarray, dt: float, steps: int) -> np.ndarray:
    step, states = expm(A * dt), [start]
    for _ in range(steps):
        states.append(step @ states[-1])
    return np.array(states)


def system_of(model: Model) -> OwnSystem:
    """The plant, balanced. Raises KnobError where there is nothing to cut, EngineError where Gramians are lost in rounding."""
    plant = model.plant
    unstable = plant.n - split_stable(plant).stable.n
    for order in range(plant.n, unstable, -1):
        try:
            return OwnSystem(model, balanced_truncation(plant, order))
        except EngineError:
            continue
    raise KnobError(text("This lesson leaves states out by their Hankel values. This plant has no stable state between input and output."))
