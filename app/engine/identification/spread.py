"""Spread of fitted poles: fit many records that the fitted model itself makes."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.special import chdtri, ndtr, ndtri

from ..systems.recursions import affine_scan
from .noise_fit import NoiseFit, Tell, silent, steady_gain
from .predictor import Pieces
from .subspace import Subspace

__all__ = ["matched", "models_of", "simulated_spread", "window_grams"]

RECORDS = 100
MOST_NUMBERS = 8_000_000  # simulated at a time
SEED = 48
BAND = 0.95  # share of the simulated poles that lie in the band of this share
SURE = 1e-9  # of the real part's variance: below it the imaginary part is sure


def simulated_spread(found: Subspace, noises: NoiseFit, pieces: Pieces, rows: int,
                     tell: Tell = silent) -> tuple[np.ndarray, np.ndarray] | None:
    """Covariance (n, 2, 2) of real and imaginary part of each pole about the fitted one, and the 95 % interval (n, 2) of each real pole.

    None where the model makes no finite record; NaN for the interval of a pair.

    Parametric bootstrap: x̂⁺ = A x̂ + B u + K e, y = C x̂ + D u + e with the record's u and new e ~ N(0, S N/(N − d)), d parameters for
    each output; each record is fitted as the first one was. The 95 % ellipse of a pair holds each simulated pole with probability 95 %
    where it is made from the others. The interval of a real pole is the bias-corrected percentile interval. Both are for `rows` rows.
    Source: Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapters 6, 14 and 21.
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            poles = _simulated_poles(found, noises, pieces, tell)
    except np.linalg.LinAlgError:
        return None
    if not np.isfinite(poles).all():
        return None
    away = np.array([matched(found.poles, other) for other in poles]) - found.poles
    mirror = np.abs(found.poles - found.poles.conj()[:, None]).argmin(axis=1)  # a pair has one spread, and a real pole one that is even
    away = np.vstack([away, away[:, mirror].conj()])
    parts = np.stack([away.real, away.imag], axis=-1)
    share = sum(len(u) for u, _ in pieces.pairs) / rows
    spread = share * np.array([_calibrated(parts[:, k], len(poles)) for k in range(parts.shape[1])])
    return spread, _intervals(found.poles, poles, share)


def _calibrated(away: np.ndarray, count: int) -> np.ndarray:
    """Covariance (2, 2) of deviations (J, 2), the first `count` of them simulated, times what brings the share BAND into its ellipse.

    eᵀ V⁻¹ e of each with the V of all others, by the rank-one update, and the quantile at rank BAND (J + 1): few records make no band
    too narrow.
    """
    spread, own = away.T @ away / len(away), away[:count]
    if spread[1, 1] <= SURE * spread[0, 0]:
        return _upper(own[:, 0] ** 2) / chdtri(1, 1 - BAND) * np.diag([1.0, 0.0])
    sizes = np.einsum("ji,ik,jk->j", own, np.linalg.pinv(spread), own)
    without = sizes * (1 - 1 / count) / np.maximum(1 - sizes / count, 1 / count)
    return _upper(without) / chdtri(2, 1 - BAND) * spread


def _upper(values: np.ndarray) -> float:
    """What a further value stays below with probability BAND."""
    return float(np.quantile(values, BAND, method="weibull"))


def _intervals(poles: np.ndarray, simulated: np.ndarray, share: float) -> np.ndarray:
    """The bias-corrected percentile interval (n, 2) of each real pole, stretched about it by √share; NaN for pairs.

    Ends at the shares Φ(2 z₀ ± z) of the simulated values, z₀ = Φ⁻¹ of the share below the fitted pole: poles that lie near each other
    are drawn apart by noise, and their errors are skew.
    """
    out, z = np.full((len(poles), 2), np.nan), float(ndtri((1 + BAND) / 2))
    real = np.abs(poles.imag) <= SURE
    each = np.sort_complex(simulated).real if real.all() else np.array([matched(poles, other).real for other in simulated])
    least = 0.5 / len(simulated)
    for k in np.flatnonzero(real):
        below = float(ndtri(np.clip(np.mean(each[:, k] < poles[k].real), least, 1 - least)))
        ends = np.quantile(each[:, k], ndtr(2 * below + np.array([-z, z])), method="weibull")
        out[k] = poles[k].real + np.sqrt(share) * (ends - poles[k].real)
    return out


def matched(poles: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The other poles in the order of those to which they belong."""
    return other[linear_sum_assignment(np.abs(poles[:, None] - other))[1]]


def _simulated_poles(found: Subspace, noises: NoiseFit, pieces: Pieces, tell: Tell) -> np.ndarray:
    """Poles (J, n) of the fits to J records that the model makes. Raises LinAlgError."""
    n, p, m = len(found.A), len(found.C), noises.B.shape[1]
    K, S = steady_gain(found.A, found.C, noises.Q, noises.R)
    each = min((n * m + p * m + 2 * n * p) / p, 0.5 * pieces.rows)
    root = np.linalg.cholesky(S * pieces.rows / (pieces.rows - each))
    u_size, y_size = (np.sqrt((np.vstack(part) ** 2).mean(axis=0)) + 1e-300 for part in zip(*pieces.pairs, strict=True))
    answers = [affine_scan(found.A, u @ noises.B.T, start, len(u))[:-1] @ found.C.T + u @ noises.D.T
               for (u, _), start in zip(pieces.pairs, noises.starts, strict=True)]
    rng, models = np.random.default_rng(SEED), []
    at_once = int(np.clip(MOST_NUMBERS // (max(map(len, answers)) * (m + p)), 1, RECORDS))
    for first in range(0, RECORDS, at_once):
        count, grams = min(at_once, RECORDS - first), np.zeros(())
        for (u, _), answer in zip(pieces.pairs, answers, strict=True):
            y = answer[:, :, None] + _noise(found.A, found.C, K, rng.standard_normal((len(u), p, count)), root)
            grams = grams + window_grams(u / u_size, y / y_size[:, None], found.horizon)
        if not np.isfinite(grams).all():
            raise np.linalg.LinAlgError
        models.append(models_of(grams, found.horizon, m, n))
        tell((first + count) / RECORDS)
    return np.linalg.eigvals(np.concatenate(models))


def _noise(A: np.ndarray, C: np.ndarray, K: np.ndarray, e: np.ndarray, root: np.ndarray) -> np.ndarray:
    """What innovations e (N, p, J) of unit variance make of the outputs of a predictor at rest: (N, p, J)."""
    e = np.einsum("pq,tqj->tpj", root, e) if len(root) > 1 else root[0, 0] * e
    x, out = np.zeros((len(A), e.shape[2])), np.empty_like(e)
    for k, now in enumerate(e):
        out[k] = C @ x + now
        x = A @ x + K @ now
    return out


def window_grams(u: np.ndarray, y: np.ndarray, horizon: int) -> np.ndarray:
    """Gram matrices (J, c, c) of the windows of u (N, m) and y (N, p, J), columns as in `Factors`.

    Entry (i + 1, j + 1) of their Toeplitz-like blocks is entry (i, j) with one row less and one more.
    """
    (N, m), (_, p, J) = u.shape, y.shape
    z = np.concatenate([np.broadcast_to(u[:, :, None], (N, m, J)), y], axis=1).transpose(2, 0, 1)
    steps, width = 2 * horizon, m + p
    count = N - steps + 1
    G = np.empty((steps, steps, J, width, width))
    head = z[:, :count].transpose(0, 2, 1)
    for j in range(steps):
        G[0, j] = head @ z[:, j:j + count]
    first, last = z[:, :steps], z[:, count:]
    for i in range(steps - 1):
        for j in range(i, steps - 1):
            G[i + 1, j + 1] = (G[i, j] - first[:, i, :, None] * first[:, j, None, :] + last[:, i, :, None] * last[:, j, None, :])
    for i in range(1, steps):
        for j in range(i):
            G[i, j] = G[j, i].transpose(0, 2, 1)
    at = np.arange(steps * width).reshape(steps, width)
    order = np.concatenate([part.reshape(-1) for part in (at[horizon:, :m], at[:horizon, m:], at[:horizon, :m], at[horizon:, m:])])
    whole = G.transpose(2, 0, 3, 1, 4).reshape(J, steps * width, steps * width)
    return whole[:, order[:, None], order]


def models_of(grams: np.ndarray, horizon: int, m: int, n: int) -> np.ndarray:
    """A (J, n, n) of each Gram matrix, as `subspace` finds it."""
    p = grams.shape[1] // (2 * horizon) - m
    tiny = 1e-14 * np.einsum("jii->ji", grams)[:, :, None] * np.eye(grams.shape[1])
    L = np.linalg.cholesky(grams + tiny)
    inputs, known = horizon * m, horizon * (2 * m + p)
    L32, L33 = L[:, known:, inputs:known], L[:, known:, known:]
    W = np.linalg.cholesky(L32 @ L32.transpose(0, 2, 1) + L33 @ L33.transpose(0, 2, 1))
    U, values, _ = np.linalg.svd(np.linalg.solve(W, L32), full_matrices=False)
    Gamma = W @ (U[:, :, :n] * np.sqrt(values[:, None, :n]))
    return np.linalg.pinv(Gamma[:, :-p]) @ Gamma[:, p:]
