"""Fit a record with scattered gaps: fill them by the model, fit again, count measured rows alone."""

from __future__ import annotations

import numpy as np

from ..filters import Belief, KalmanFilter
from .noise_fit import NoiseFit, fit_noise_to
from .predictor import Pieces, filled_pieces, pieces_of
from .probe import filled
from .smoother import smooth
from .subspace import Subspace, subspace
from .windows import segments_of

__all__ = ["fit_states", "started"]

ENOUGH = 0.9  # share of the rows in stretches without a gap, from which the stretches alone are fitted
ROUNDS = 4  # of filling and fitting


def fit_states(u: np.ndarray, y: np.ndarray, order: int | None) -> tuple[Subspace, NoiseFit, Pieces]:
    """A, C by subspace and B, D, Q, R by likelihood, of inputs and outputs about their level; NaN where a measurement is missing.

    Where long stretches are whole, they are fitted. Otherwise each gap is filled by the smoother of the fit before, as in the EM
    method, and the likelihood counts measured rows alone. Source: Shumway and Stoffer, Journal of Time Series Analysis 3 (1982) 253–264.
    """
    seen = np.isfinite(y).all(axis=1)
    shortest = 2 * max(5, len(y) // (30 * (u.shape[1] + y.shape[1])) if len(y) else 5)
    whole = sum(b - a for a, b in segments_of(y, min(shortest, 30)))
    if whole >= ENOUGH * len(y) or seen.all():
        found = subspace(u, y, order=order)
        pieces = pieces_of(u, y, 2 * found.horizon)
        return found, fit_noise_to(found.A, found.C, pieces), pieces
    work = filled(y)
    for _ in range(ROUNDS):
        found = subspace(u, work, order=order)
        pieces = filled_pieces(u, work, seen)
        noises = fit_noise_to(found.A, found.C, pieces)
        kf = KalmanFilter(found.A, noises.B, found.C, noises.Q, noises.R, noises.D)
        track = kf.run(started(kf, y), y, u if u.shape[1] else None)
        expected = smooth(kf, track).means @ found.C.T + u @ noises.D.T
        work = np.where(np.isfinite(y), y, expected)
    return found, noises, pieces


def started(kf: KalmanFilter, y: np.ndarray) -> Belief:
    """A start that knows nothing: zero, ten times as uncertain as the outputs vary."""
    size = np.linalg.norm(np.nanstd(y, axis=0)) / max(float(np.linalg.norm(kf.C)), 1e-300)
    return Belief(np.zeros(kf.n), 10.0 * size**2 * np.eye(kf.n) + kf.Q)
