"""The Rauch–Tung–Striebel smoother over a filtered record."""

from __future__ import annotations

import numpy as np

from ..filters import KalmanFilter, Track
from ..systems.arrays import symmetric
from ..systems.records import record as a_record
from ..systems.recursions import affine_scan

__all__ = ["Smoothed", "smooth"]

SINGULAR = 1e-13  # of the largest eigenvalue
SETTLED = 1e-10  # relative change of the smoothed covariance that counts as none


@a_record()
class Smoothed:
    """What the whole record says of each state: means (n_t, n) and variances (n_t, n) of x[k] given y[0 … N]."""

    means: np.ndarray
    variances: np.ndarray


def smooth(kf: KalmanFilter, track: Track) -> Smoothed:
    """x̂[k|N] = x̂[k|k] + J (x̂[k+1|N] − x̂[k+1|k]), P[k|N] = P[k|k] + J (P[k+1|N] − P[k+1|k]) Jᵀ, J = P[k|k] Aᵀ P[k+1|k]⁻¹.

    A P[k+1|k] that is singular, as where R is nearly zero, takes the pseudo-inverse. Where the filter has settled J is constant: the
    means go backwards in blocks, the covariances until they settle too.
    Source: Rauch, Tung and Striebel, AIAA Journal 3 (1965) 1445–1450.
    """
    schedule = track.schedule
    posterior, steps, count = schedule.posterior, len(track.means), len(schedule.posterior)
    A = kf.A
    ahead = symmetric(A @ posterior @ A.T) + kf.Q
    J = np.swapaxes(_solved(ahead, A @ posterior), 1, 2)
    means, variances = np.array(track.means), np.empty_like(track.means)
    last = count - 1
    tail = np.arange(steps - 2, last - 1, -1)  # rows of which J is the last one, from the end backwards
    if len(tail):
        forcing = track.means[tail] - track.predicted[tail + 1] @ J[last].T
        means[tail] = affine_scan(J[last], forcing, means[steps - 1], len(tail))[1:]
    for k in range(min(last, steps - 1) - 1, -1, -1):
        means[k] += J[k] @ (means[k + 1] - track.predicted[k + 1])
    P = posterior[last]
    variances[steps - 1] = np.diag(P)
    for k in range(steps - 2, -1, -1):
        at = min(k, last)
        new = symmetric(posterior[at] + J[at] @ (P - ahead[at]) @ J[at].T)
        variances[k] = np.diag(new)
        if at == last and k > last and np.abs(new - P).max() <= SETTLED * np.abs(new).max():
            variances[last:k] = np.diag(new)
            for early in range(last - 1, -1, -1):
                new = symmetric(posterior[early] + J[early] @ (new - ahead[early]) @ J[early].T)
                variances[early] = np.diag(new)
            break
        P = new
    return Smoothed(means, np.maximum(variances, 0.0))


def _solved(P: np.ndarray, right: np.ndarray) -> np.ndarray:
    """P⁻¹ times the right side, over stacks (k, n, n)."""
    sizes = np.linalg.eigvalsh(P)
    if (sizes[:, 0] > SINGULAR * sizes[:, -1]).all():
        return np.linalg.solve(P, right)
    return np.linalg.pinv(P, rcond=SINGULAR, hermitian=True) @ right
