"""Estimate the last samples' most likely states within bounds, by one quadratic program a sample."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...plotting import plot_signals
from ...systems.arrays import as_definite, solve_scaled
from ...systems.errors import EngineError, ShapeError
from ...systems.gates.argument_checks import RECORD, array, count, instance, optional, takes
from ...systems.noise import root
from ...systems.records import record
from ..belief import BELIEF, Belief
from ..linear.linear_filter import LinearFilter
from ..track import as_record

if TYPE_CHECKING:
    from ...plotting import Axes

__all__ = ["HorizonTrack", "moving_horizon"]

INSIDE = 1e-9  # of a state's own deviation in the window: how far outside a bound it may lie
ROUNDING = 1e-13  # of the numbers that a state is summed from
TOLERANCE = 1e-10  # of the same deviation: what the quadratic program may leave


@record()
class HorizonTrack:
    """Estimates x̂[k] (n_t, n) with all samples up to k, and whether a bound acted on each (n_t,; bool)."""

    means: np.ndarray
    bounded: np.ndarray

    def plot(self, *, dt: float = 0.0) -> list[Axes]:
        """The estimates, a panel each state."""
        k = np.arange(len(self.means))
        return plot_signals(k * dt if dt else k, {f"x{i + 1}": {"estimate": x} for i, x in enumerate(self.means.T)},
                            time="t (s)" if dt else "sample")


@takes(model=instance(LinearFilter), y=RECORD, start=optional(BELIEF), lower=optional(array(infinite=True)),
       upper=optional(array(infinite=True)), horizon=count(1, 1000))
def moving_horizon(model: LinearFilter, y: object, u: object | None = None, *, start: Belief | None = None, lower: object | None = None,
                   upper: object | None = None, horizon: int = 10) -> HorizonTrack:
    """The states of the last `horizon` samples that minimise |x₀ − x̄|²_P⁻¹ + Σ|w|²_Q⁻¹ + Σ|y − Cx − Du|²_R⁻¹ within bounds.

    `lower` and `upper` are numbers or vectors (n,), infinite where there is no bound. What came before the horizon counts as
    x̄, the estimate led one step on, with the covariance P of the Kalman filter: without bounds this is the Kalman filter.
    Q may be singular, R not. `start` is (mean, covariance), by default that of `model.run`. Bounds that act need the package
    daqp, `pip install "observer-lab[estimation]"`. Raises EngineError where no state is within the bounds, ShapeError.

    >>> kf = KalmanFilter([[1]], [[0]], [[1]], 1.0, 1.0)
    >>> np.round(moving_horizon(kf, [-3.0, 1.0], start=([0], 1.0), lower=0.0).means[1], 4)
    array([0.5])
    """
    y = as_record(y, "y", len(model.C))
    known, push = y, np.zeros((len(y), model.n))
    if u is not None:
        u = as_record(u, "u", model.B.shape[1], rows=len(y))
        if np.isnan(u).any():
            raise EngineError("u holds NaN; every input must be known.")
        known, push = y - u @ model.D.T, u @ model.B.T
    start = model.default_start if start is None else start
    if start.mean.size != model.n:
        raise ShapeError("The belief is about {mean_size} states but the filter has {n}; give both the same number.",
                         mean_size=start.mean.size, n=model.n)
    low, high = _bound(lower, "lower", -np.inf, model.n), _bound(upper, "upper", np.inf, model.n)
    if (low > high).any():
        raise EngineError("lower must not lie above upper; exchange the bounds.")
    seen = np.isfinite(known)
    schedule = model.schedule(start, len(y), seen=None if seen.all() else seen)
    window = _Window(model.A, model.C, root(model.Q), as_definite(model.R, "R", len(model.R)), low, high)
    means, bounded = np.empty((len(y), model.n)), np.zeros(len(y), dtype=bool)
    priors = schedule.prior[schedule.index]
    for k in range(len(y)):
        first = max(0, k - horizon + 1)
        middle = start.mean if first == 0 else model.A @ means[first - 1] + push[first - 1]
        means[k], bounded[k] = window.last(middle, priors[first], known[first:k + 1], push[first:k])
    return HorizonTrack(means, bounded)


def _bound(value: Any, name: str, free: float, n: int) -> np.ndarray:
    found = np.full(n, free) if value is None else np.asarray(value, dtype=float)
    if found.shape not in ((), (1,), (n,)):
        raise ShapeError("{name} must have {length} entries; it has {vector_size}.", name=name, length=n, vector_size=found.size)
    return np.broadcast_to(found, (n,))


@record()
class _Window:
    A: np.ndarray
    C: np.ndarray
    noise: np.ndarray  # a root of Q
    R: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def last(self, middle: np.ndarray, P: np.ndarray, known: np.ndarray, push: np.ndarray) -> tuple[np.ndarray, bool]:
        """The last state of a window, and whether a bound acted on one of its states.

        All states are free + T z with z = (ξ, ω₀, …), x₀ = x̄ + √P ξ, w = √Q ω: the cost |z|² + Σ|y − Cx|²_R⁻¹ is strictly convex.
        """
        n, q, length = len(middle), self.noise.shape[1], len(known)
        T, free = np.zeros((length, n, n + q * (length - 1))), np.empty((length, n))
        T[0, :, :n], free[0] = root(P), middle
        for j in range(1, length):
            T[j], free[j] = self.A @ T[j - 1], self.A @ free[j - 1] + push[j - 1]
            T[j, :, n + q * (j - 1):n + q * j] = self.noise
        H, f = np.eye(T.shape[2]), np.zeros(T.shape[2])
        for j in range(length):
            seen = np.isfinite(known[j])
            rows, weight = self.C[seen] @ T[j], self.R[np.ix_(seen, seen)]
            across = solve_scaled(weight, rows).T if seen.any() else rows.T
            H += across @ rows
            f -= across @ (known[j, seen] - self.C[seen] @ free[j])
        z = np.linalg.solve(H, -f)
        reach, begun = T.reshape(-1, len(f)), free.ravel()
        low, high = (np.tile(bound, length) - begun for bound in (self.low, self.high))
        deviation = np.linalg.norm(reach, axis=1)
        room = INSIDE * deviation + ROUNDING * (np.abs(begun) + np.abs(reach) @ np.abs(z))
        moved = reach @ z
        if (moved >= low - room).all() and (moved <= high + room).all():
            return free[-1] + T[-1] @ z, False
        z = _bounded(H, f, reach, low, high, deviation, room)
        return free[-1] + T[-1] @ z, True


def _bounded(H: np.ndarray, f: np.ndarray, T: np.ndarray, low: np.ndarray, high: np.ndarray, deviation: np.ndarray,
             room: np.ndarray) -> np.ndarray:
    """The z of least cost with low ≤ T z ≤ high, each row in units of its own deviation."""
    try:
        import daqp
    except ImportError as problem:
        raise EngineError('Bounds need the package daqp; run pip install "observer-lab[estimation]".') from problem
    still = deviation == 0
    if (low[still] > room[still]).any() or (high[still] < -room[still]).any():
        raise _out_of_reach()
    kept = (np.isfinite(low) | np.isfinite(high)) & ~still
    unit = deviation[kept]
    z, _, ended, _ = daqp.solve(H, f, np.ascontiguousarray(T[kept] / unit[:, None]), np.minimum(high[kept] / unit, 1e30),
                                np.maximum(low[kept] / unit, -1e30), np.zeros(len(unit), dtype=np.int32), primal_tol=TOLERANCE)
    if ended < 1:
        raise _out_of_reach()
    return np.asarray(z)


def _out_of_reach() -> EngineError:
    return EngineError("No state of the model is within the bounds and the noise; widen the bounds, or raise Q.")
