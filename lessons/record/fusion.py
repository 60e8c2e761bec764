"""Put a second, slow and exact sensor beside the first one of a record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from observer_lab.engine import KalmanFilter

from .knobs import LATE

EVERY, DELAY = 10, 5  # rows between readings of the second sensor; rows that a late one takes
FINER = 10.0  # times that it is more exact than the first
BEFORE, SHOWN = 20, 60  # rows that run before the first that is shown, and rows that are shown


@dataclass(frozen=True, eq=False)
class Fusion:
    """Standard deviations of the estimated output along the rows that are shown: with one sensor, and with both."""

    alone: np.ndarray
    both: np.ndarray
    exact: float  # that of the second sensor

    @property
    def period(self) -> np.ndarray:
        """Those with both over the last period."""
        return self.both[-EVERY:]


def fused(kf: KalmanFilter, prior: np.ndarray, second: str) -> Fusion:
    """σ of the first output from P[k|k−1] = prior (n×n) on; `second` says how the second sensor comes.

    A reading that is d rows late is about z = C x of d rows ago, which d further states keep: z₁⁺ = C x, z_j⁺ = z_{j−1}.
    Source: Anderson and Moore, Optimal Filtering (1979), section 7.3.
    """
    late = DELAY if second == LATE else 0
    n, p, first = kf.n, len(kf.C), kf.C[:1]
    A = np.zeros((n + late, n + late))
    A[:n, :n] = kf.A
    C = np.zeros((p + 1, n + late))
    C[:p, :n] = kf.C
    if late:
        A[n, :n] = first
        A[n + 1:, n:-1] = np.eye(late - 1)
        C[p, -1] = 1.0
    else:
        C[p, :n] = first
    Q, R, P = np.zeros_like(A), np.zeros((p + 1, p + 1)), np.zeros_like(A)
    exact = float(np.sqrt(kf.R[0, 0])) / FINER
    Q[:n, :n], P[:n, :n] = kf.Q, prior
    R[:p, :p], R[p, p] = kf.R, exact**2
    wide = KalmanFilter(A, np.zeros((n + late, 0)), C, Q, R, None, kf.dt)
    rows = np.arange(-BEFORE, SHOWN)
    seen = np.ones((len(rows), p + 1), dtype=bool)
    seen[:, p] = (rows > 0) & (rows % EVERY == late % EVERY)
    sigmas = []
    for arrives in (np.where(np.arange(p + 1) == p, False, seen), seen):
        schedule = wide.schedule((np.zeros(n + late), P), len(rows), seen=arrives)
        inner = schedule.posterior[schedule.index][BEFORE:, :n, :n]
        sigmas.append(np.sqrt(np.maximum(np.einsum("pi,tij,pj->t", first, inner, first), 0.0)))
    return Fusion(sigmas[0], sigmas[1], exact)
