"""The Rauch–Tung–Striebel smoother: each state from the whole record, the samples after it too."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...plotting import plot_estimates
from ...systems.arrays import LEAST_DEVIATION, symmetric
from ...systems.errors import EngineError, ShapeError
from ...systems.gates.argument_checks import instance, takes
from ...systems.records import record
from ...systems.recursions import affine_scan
from ..linear.linear_filter import LinearFilter
from ..nonlinear.differences import Combine, minus, plus
from ..nonlinear.nonlinear_filter import NonlinearFilter
from ..track import Track

if TYPE_CHECKING:
    from ...plotting import Axes

__all__ = ["Smoothed", "smooth"]

STEADY_RTOL = 1e-14  # of the largest covariance: a change below it is none


@record()
class Smoothed:
    """A record smoothed: means x̂[k|N] (n_t, n), covariances P[k|N] (n_t, n, n), gains G (n_t − 1, n, n)."""

    means: np.ndarray
    covariances: np.ndarray
    gains: np.ndarray

    @property
    def variances(self) -> np.ndarray:
        """The diagonals of P[k|N], (n_t, n)."""
        return np.diagonal(self.covariances, axis1=1, axis2=2)

    def plot(self, *, dt: float = 0.0) -> list[Axes]:
        """The means with two standard deviations to either side, a panel each state."""
        return plot_estimates(self.means, self.variances, dt=dt)


@takes(model=instance(LinearFilter, NonlinearFilter), track=instance(Track))
def smooth(model: LinearFilter | NonlinearFilter, track: Track) -> Smoothed:
    """x̂[k|N] and P[k|N] of a record that `model` has filtered: backwards from the last sample.

    G = P[k|k] Aᵀ P[k+1|k]⁻¹, x̂[k|N] = x̂[k|k] + G (x̂[k+1|N] − x̂[k+1|k]), P[k|N] = P[k|k] + G (P[k+1|N] − P[k+1|k]) Gᵀ
    (Rauch, Tung and Striebel 1965). Of an extended filter A is the slope at x̂[k|k]; of an unscented one P[k|k] Aᵀ is the covariance of
    x[k] and x[k+1] over its points (Särkkä 2008). Times, noises and gates are those of the track. Directions of which nothing is
    unsure are left as they are. Raises ShapeError where the track is of another model.

    >>> kf = KalmanFilter([[1]], [[0]], [[1]], 1.0, 1.0)
    >>> np.round(smooth(kf, kf.run(([0], 1.0), [1.0, 2.0, 3.0])).means[:, 0], 4)
    array([0.9231, 1.7692, 2.3846])
    """
    n, steps = track.means.shape[1] if track.across is not None and not isinstance(model, LinearFilter) else model.n, len(track.means)
    apart, together = (None, None) if isinstance(model, LinearFilter) else (model.x_minus, model.x_plus)
    if track.means.shape[1] != n:
        raise ShapeError("The track is of {count} states but the filter has {n}; smooth it with the filter that made it.",
                         count=track.means.shape[1], n=n)
    s = track.schedule
    posterior, index = s.posterior, s.index
    if track.across is None:
        across, ahead, which = posterior @ _step(model).T, s.prior[np.minimum(np.arange(len(s.prior)) + 1, len(s.prior) - 1)], index[:-1]
    else:
        across, ahead, which = track.across, s.prior[index[1:]], np.arange(steps - 1)
    each = _gains(across, ahead) if steps > 1 else np.zeros((1, n, n))
    rest = symmetric(posterior[:len(each)] - each @ ahead[:len(each)] @ each.swapaxes(-1, -2))  # what x[k+1] leaves unsure of x[k]
    tail = steps - 1 if s.settled is None or track.across is not None else min(s.settled, steps - 1)  # gains do not change from here
    means = track.means.copy()
    _smooth_means(means, track.predicted, each, which, tail, apart, together)
    return Smoothed(means, _covariances(posterior[index[-1]], each, rest, which, tail), each[which])


def _smooth_means(means: np.ndarray, predicted: np.ndarray, each: np.ndarray, which: np.ndarray, tail: int, apart: Combine | None,
                  together: Combine | None) -> None:
    """x̂[k|N] = x̂[k|k] + G (x̂[k+1|N] − x̂[k+1|k]) from the last sample back, in place; at once where G stays the same."""
    last = len(which)
    if apart is not None or together is not None:
        for k in range(last - 1, -1, -1):
            means[k] = plus(together, means[k], each[which[k]] @ minus(apart, means[k + 1], predicted[k + 1]))
        return
    G = each[which]
    forcing = means[:-1] - (G @ predicted[1:, :, None])[:, :, 0]
    if tail < last:
        means[tail:] = affine_scan(G[-1], forcing[tail:][::-1], means[-1], last - tail)[::-1]
    x = means[tail]
    for k in range(tail - 1, -1, -1):
        means[k] = x = G[k] @ x + forcing[k]


def _covariances(last: np.ndarray, each: np.ndarray, rest: np.ndarray, which: np.ndarray, tail: int) -> np.ndarray:
    """P[k|N] = rest + G P[k+1|N] Gᵀ from the last sample back; where G stays the same, until it stays the same too."""
    found = np.empty((len(which) + 1, *last.shape))
    found[-1] = P = last
    k = len(which) - 1
    while k >= 0:
        i = which[k]
        before, P = P, symmetric(rest[i] + each[i] @ P @ each[i].T)
        found[k] = P
        if k > tail and np.abs(P - before).max(initial=0.0) <= STEADY_RTOL * np.abs(P).max(initial=0.0):
            found[tail:k] = P
            P, k = found[k], tail
        k -= 1
    return found


def _step(model: LinearFilter | NonlinearFilter) -> np.ndarray:
    if isinstance(model, LinearFilter):
        return model.A
    raise EngineError("The track is not one of this filter; smooth it with the filter that made it.")


def _gains(across: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """across (ahead)⁺ of each in a stack, in units in which the entries of `ahead` are correlations."""
    spread = np.sqrt(np.abs(np.diagonal(ahead, axis1=1, axis2=2)))
    spread = np.where(spread > LEAST_DEVIATION, spread, 1.0)
    even = ahead / (spread[:, :, None] * spread[:, None, :])
    return across / spread[:, None, :] @ np.linalg.pinv(even, rcond=1e-14, hermitian=True) / spread[:, None, :]
