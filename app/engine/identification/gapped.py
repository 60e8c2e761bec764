"""Fit a record with scattered gaps: fill them by the model, fit again, count measured rows alone."""

from __future__ import annotations

from contextlib import nullcontext, suppress
from dataclasses import replace

import numpy as np

from ..filters import Belief, KalmanFilter
from ..systems.errors import EngineError
from .noise_fit import NoiseFit, Tell, fit_noise_to, part_of, silent
from .predictor import MAX_GAPPED_ROWS, Pieces, gapped_pieces, pieces_of
from .probe import filled
from .smoother import smooth
from .spread import simulated_spread
from .subspace import Subspace, subspace
from .windows import segments_of

__all__ = ["fit_states", "in_long_stretches", "started"]

ENOUGH, STRETCHES = 0.9, 8  # share of the rows in the longest stretches without a gap, from which they alone are fitted; how many
ROUNDS = 3  # of filling and fitting
FITTED = 0.7  # of the work, before the spread


def fit_states(u: np.ndarray, y: np.ndarray, order: int | None, tell: Tell = silent) -> tuple[Subspace, NoiseFit, Pieces]:
    """A, C by subspace and B, D, Q, R by likelihood, of inputs and outputs about their level; NaN where a measurement is missing.

    Where long stretches are whole, they are fitted. Otherwise each gap is filled for the subspace method by the smoother of the fit
    before; the likelihood is that of all readings, with a gain for each row. The spread of the poles is that of `simulated_spread`.
    `order` None takes the largest order, up to the suggested one, for which there is a filter.
    Source: Shumway and Stoffer, Journal of Time Series Analysis 3 (1982) 253–264.
    """
    fit = _whole if in_long_stretches(y) else _gapped
    if order is not None:
        return _with_spread(*fit(u, y, order, part_of(tell, 0.0, FITTED)), y, part_of(tell, FITTED, 1.0))
    suggested = subspace(u, y if fit is _whole else filled(y)).suggested
    for n in range(suggested, 0, -1):
        with suppress(EngineError) if n > 1 else nullcontext():
            found, noises, pieces = fit(u, y, n, part_of(tell, 0.0, FITTED))
            break
    return _with_spread(replace(found, suggested=suggested), noises, pieces, y, part_of(tell, FITTED, 1.0))


def _with_spread(found: Subspace, noises: NoiseFit, pieces: Pieces, y: np.ndarray, tell: Tell) -> tuple[Subspace, NoiseFit, Pieces]:
    """The fit with spread and intervals of records that the model makes, and the spread of the jackknife where it makes none."""
    simulated = simulated_spread(found, noises, pieces, round(np.isfinite(y).sum() / y.shape[1]), tell)
    if simulated is not None:
        spread, intervals = simulated
        found = replace(found, spread=spread, intervals=intervals, deviations=np.sqrt(np.trace(spread, axis1=1, axis2=2)))
    return found, noises, pieces


def _whole(u: np.ndarray, y: np.ndarray, order: int, tell: Tell) -> tuple[Subspace, NoiseFit, Pieces]:
    """The fit to a few long stretches."""
    found = subspace(u, y, order=order)
    pieces = pieces_of(u, y, 2 * found.horizon)
    return found, fit_noise_to(found.A, found.C, pieces, None, part_of(tell, 0.1, 1.0)), pieces


def _gapped(u: np.ndarray, y: np.ndarray, order: int, tell: Tell) -> tuple[Subspace, NoiseFit, Pieces]:
    """The fit to all rows, with gaps that are filled by the fit before."""
    work, pieces = filled(y), gapped_pieces(u, y)
    for k in range(ROUNDS):
        found = subspace(u, work, order=order)
        noises = fit_noise_to(found.A, found.C, pieces, None, part_of(tell, k / ROUNDS, (k + 1) / ROUNDS))
        kf = KalmanFilter(found.A, noises.B, found.C, noises.Q, noises.R, noises.D)
        track = kf.run(started(kf, y), y, u if u.shape[1] else None)
        expected = smooth(kf, track).means @ found.C.T + u @ noises.D.T
        work = np.where(np.isfinite(y), y, expected)
    return found, noises, pieces


def in_long_stretches(y: np.ndarray) -> bool:
    """Whether a few stretches without a gap hold nearly all rows: each has a start of its own, which short ones are all about.

    No if rows with a part of their outputs add more readings than they would lose.
    """
    seen = np.isfinite(y)
    lengths = sorted((b - a for a, b in segments_of(y, 1)), reverse=True)
    long = sum(lengths[:STRETCHES])
    if (seen.any(axis=1) & ~seen.all(axis=1)).any() and seen[:MAX_GAPPED_ROWS].sum() > long * y.shape[1]:
        return False
    return long >= ENOUGH * len(y)


def started(kf: KalmanFilter, y: np.ndarray) -> Belief:
    """A start that knows nothing: zero, ten times as uncertain as the outputs vary."""
    size = np.linalg.norm(np.nanstd(y, axis=0)) / max(float(np.linalg.norm(kf.C)), 1e-300)
    return Belief(np.zeros(kf.n), 10.0 * size**2 * np.eye(kf.n) + kf.Q)
