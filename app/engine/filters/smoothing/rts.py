"""The Rauch–Tung–Striebel smoother: each state from the whole record, the samples after it too."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...plotting import plot_estimates
from ...systems.arrays import correlations, symmetric
from ...systems.errors import ShapeError
from ...systems.gates.argument_checks import instance, takes
from ...systems.records import record
from ..linear.linear_filter import LinearFilter
from ..track import Track

if TYPE_CHECKING:
    from ...plotting import Axes

__all__ = ["Smoothed", "smooth"]


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


@takes(model=instance(LinearFilter), track=instance(Track))
def smooth(model: LinearFilter, track: Track) -> Smoothed:
    """x̂[k|N] and P[k|N] of a record that `model` has filtered: backwards from the last sample.

    G = P[k|k] Aᵀ P[k+1|k]⁻¹, x̂[k|N] = x̂[k|k] + G (x̂[k+1|N] − x̂[k+1|k]), P[k|N] = P[k|k] + G (P[k+1|N] − P[k+1|k]) Gᵀ
    (Rauch, Tung and Striebel 1965). Directions of which nothing is unsure are left as they are. Raises ShapeError where
    the track is of another model.

    >>> kf = KalmanFilter([[1]], [[0]], [[1]], 1.0, 1.0)
    >>> np.round(smooth(kf, kf.run(([0], 1.0), [1.0, 2.0, 3.0])).means[:, 0], 4)
    array([0.9231, 1.7692, 2.3846])
    """
    n, steps = model.n, len(track.means)
    if track.means.shape[1] != n:
        raise ShapeError("The track is of {count} states but the filter has {n}; smooth it with the filter that made it.",
                         count=track.means.shape[1], n=n)
    posterior, prior, index = track.schedule.posterior, track.schedule.prior, track.schedule.index
    means, covariances = track.means.copy(), posterior[index].copy()
    gains = np.empty((max(steps - 1, 0), n, n))
    for k in range(steps - 2, -1, -1):
        if k + 2 < steps and index[k] == index[k + 1] and index[k + 1] == index[k + 2]:
            gains[k] = gains[k + 1]
        else:
            gains[k] = _gain(posterior[index[k]], prior[index[k + 1]], model.A)
        G = gains[k]
        means[k] += G @ (means[k + 1] - track.predicted[k + 1])
        covariances[k] = symmetric(covariances[k] + G @ (covariances[k + 1] - prior[index[k + 1]]) @ G.T)
    return Smoothed(means, covariances, gains)


def _gain(P: np.ndarray, ahead: np.ndarray, A: np.ndarray) -> np.ndarray:
    """P Aᵀ (ahead)⁺, in units in which the entries of `ahead` are correlations."""
    even, spread = correlations(ahead)
    return P @ A.T / spread @ np.linalg.pinv(even, rcond=1e-14, hermitian=True) / spread
