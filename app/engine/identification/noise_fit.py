"""Fit Q and R to a record by the likelihood of the innovations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count as counted

import numpy as np
from scipy.optimize import least_squares

from ..systems.arrays import symmetric
from ..systems.errors import EngineError
from ..systems.recursions import affine_scan
from .predictor import Pieces, fitted_inputs, prediction_errors

__all__ = ["NoiseFit", "Tell", "fit_noise_to", "part_of", "silent", "steady_gain"]

FIRST = (1e-5, 1e-3, 1e-1, 10.0)  # of Q, in units of the output's variance: where the search starts
FLOOR = 1e-9  # of Q in the same units: no state is known exactly
WORST = 1e12
SEARCH = 10  # most steps of one search
BEGUN = 0.3  # of the work, before the searches
DOUBLINGS = 60
Tell = Callable[[float], object]


def silent(share: float) -> None:
    """Nobody asks."""


def part_of(tell: Tell, first: float, last: float) -> Tell:
    """What a part tells of itself, from 0 to 1, as what the whole is: from `first` to `last`."""
    return lambda share: tell(first + (last - first) * min(share, 1.0))


@dataclass(frozen=True, eq=False)
class NoiseFit:
    """Q (n×n) and R (p×p, diagonal), and B, D and the innovations e (rows, p; NaN without a reading) that belong to them.

    Q = G Gᵀ with G n×p, which has as many entries as the record can tell. level: −2 log L for each row, less p log 2π.
    """

    Q: np.ndarray
    R: np.ndarray
    B: np.ndarray
    D: np.ndarray
    starts: np.ndarray
    innovations: np.ndarray
    level: float


def steady_gain(A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Predictor gain K = A P Cᵀ S⁻¹ (n×p) and S = C P Cᵀ + R (p×p) of the settled filter. Raises LinAlgError where there is none."""
    P = settled_covariance(A, C, Q, R)
    S = symmetric(C @ P @ C.T) + R
    return np.linalg.solve(S, C @ P @ A.T).T, S


def settled_covariance(A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray) -> np.ndarray:
    """P (n×n) of the settled predictor. Raises LinAlgError where there is none.

    By doubling, ten times as quick as SciPy's solver at these sizes: after k steps H is P of 2ᵏ samples from P = 0.
    Source: Anderson, International Journal of Control 28 (1978) 295–306. R must be positive definite.
    """
    F, G, H, eye = A.T, C.T @ np.linalg.solve(R, C), Q, np.eye(len(A))
    for _ in range(DOUBLINGS):
        right = np.linalg.solve(eye + G @ H, np.hstack([F, G]))
        step = F.T @ H @ right[:, :len(A)]
        G = symmetric(G + F @ right[:, len(A):] @ F.T)
        F, H = F @ right[:, :len(A)], symmetric(H + step)
        if not np.isfinite(H).all():
            break
        if np.abs(step).max() <= 1e-11 * np.abs(H).max():
            return H
    raise np.linalg.LinAlgError


def gains_of(A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray, pieces: Pieces) -> tuple[np.ndarray, np.ndarray]:
    """K and S of the predictor: settled, (n, p) and (p, p); where readings are missing K (N, n, p) and S (N, p, p), one for each row.

    P⁺ = A P Aᵀ + Q − K S Kᵀ from the settled P on. A reading that did not come has the gain 0, and in S the row and column of I, so
    that neither S⁻¹ e nor det S counts it. Raises LinAlgError.
    """
    if pieces.seen is None:
        return steady_gain(A, C, Q, R)
    P = settled_covariance(A, C, Q, R)
    N, p = pieces.seen.shape
    gains, sizes = np.zeros((N, len(A), p)), np.tile(np.eye(p), (N, 1, 1))
    counts = pieces.seen.sum(axis=1).tolist()
    for k, count in enumerate(counts):
        across = A @ (P @ C.T)
        if count:
            S = C @ P @ C.T + R
            if count < p:
                seen = pieces.seen[k]
                S, across = np.where(np.outer(seen, seen), S, sizes[k]), np.where(seen, across, 0.0)
            gains[k] = across / S if p == 1 else np.linalg.solve(S, across.T).T
            sizes[k] = S
        P = A @ P @ A.T + Q - gains[k] @ across.T
    return gains, sizes


def fit_noise_to(A: np.ndarray, C: np.ndarray, pieces: Pieces, known: tuple[np.ndarray, np.ndarray] | None = None,
                 tell: Tell = silent) -> NoiseFit:
    """The most likely Q and R of x⁺ = A x + B u + w, y = C x + D u + v; `known` gives B and D, else they are fitted too.

    For a settled filter −2 log L/N = log det S + tr(S⁻¹ E), E the mean of e eᵀ. S and E follow from G and the ratios of R; the common
    scale tr(S⁻¹ E)/p drops out. B, D and the starts are linear least squares between two searches.
    Source: Schweppe, IEEE Transactions on Information Theory 11 (1965) 61–70; Åström, Automatica 16 (1980) 551–574.
    """
    search = _Search(A, C, pieces, known)
    begun = []
    for k, q in enumerate(FIRST):
        begun.append(search.begun(q))
        tell(BEGUN * (k + 1) / len(FIRST))
    first = min(begun, key=lambda found: found[0])
    if not first[0] < WORST:
        raise EngineError("No filter with a settled gain was found for this plant; a mode that grows is not seen by any output.")
    x, B, D, starts = first[1:]
    for k in range(2):
        x = search.improved(x, B, D, starts, part_of(tell, BEGUN + (1 - BEGUN) * k / 2, BEGUN + (1 - BEGUN) * (k + 1) / 2))
        B, D, starts, _ = search.inputs(x)
    return search.found(x, B, D, starts)


class _Search:
    """The likelihood of one record over x = (G, ratios of R), in units of the outputs' sizes."""

    def __init__(self, A: np.ndarray, C: np.ndarray, pieces: Pieces, known: tuple[np.ndarray, np.ndarray] | None) -> None:
        self.A, self.C, self.pieces, self.known = A, C, pieces, known
        self.n, self.p = A.shape[0], C.shape[0]
        y = np.vstack([y for _, y in pieces.pairs])
        came = len(y) if pieces.seen is None else np.maximum(pieces.seen.sum(axis=0), 1)
        self.variances = np.maximum((y**2).sum(axis=0) / came, 1e-300)
        reach = max(float(np.sqrt((C**2 / self.variances[:, None]).sum())), 1e-300)
        self.unit = 1 / reach  # a state of this size gives an output of its own size

    def noises(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Q and R up to their common scale."""
        G = self.unit * x[:self.n * self.p].reshape(self.n, self.p)
        ratios = np.exp(np.clip(np.concatenate([[0.0], x[self.n * self.p:]]), -20, 20))
        return G @ G.T + FLOOR * self.unit**2 * np.eye(self.n), np.diag(self.variances * ratios)

    def gains(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """K and S at these noises."""
        return gains_of(self.A, self.C, *self.noises(x), self.pieces)

    def inputs(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """B, D, the starts and the innovations that fit best at these noises."""
        K, S = self.gains(x)
        if self.known is None:
            return fitted_inputs(self.A, self.C, K, self.pieces, S)
        B, D = self.known
        pairs = tuple((np.zeros((len(u), 0)), y - _answer(self.A, B, self.C, D, u)) for u, y in self.pieces.pairs)
        rest = replace(self.pieces, pairs=pairs)
        _, _, starts, e = fitted_inputs(self.A, self.C, K, rest, S)
        return B, D, starts, e

    def begun(self, q: float) -> tuple[float, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Likelihood, x, B, D and starts where Q = q·I: G along the gain of that filter."""
        nothing = np.zeros(0)
        try:
            K, S = steady_gain(self.A, self.C, q * self.unit**2 * np.eye(self.n), np.diag(self.variances))
            G = K @ np.linalg.cholesky(S) / self.unit
            x = np.concatenate([G.reshape(-1), np.zeros(self.p - 1)])
            B, D, starts, e = self.inputs(x)
            return self.level(x, e)[0], x, B, D, starts
        except (np.linalg.LinAlgError, ValueError):
            return WORST, nothing, nothing, nothing, nothing

    def whitened(self, S: np.ndarray, e: np.ndarray) -> np.ndarray:
        """r = g S^{-½} e of M readings, g^M = Π det S^½: its sum of squares is least where Σ log det S + M log Σ eᵀ S⁻¹ e is."""
        root = np.linalg.cholesky(S)
        logs = np.log(np.diagonal(root, axis1=-2, axis2=-1))
        middle = np.exp(logs.mean() if S.ndim == 2 else logs.sum() / self.pieces.readings)
        white = np.linalg.solve(root, e.T).T if S.ndim == 2 else np.linalg.solve(root, e[:, :, None])[:, :, 0]
        return middle * (white if self.pieces.seen is None else white[self.pieces.seen])

    def level(self, x: np.ndarray, e: np.ndarray) -> tuple[float, float]:
        """Mean of log det S + p log s and the common scale s = mean of eᵀ S⁻¹ e/p."""
        _, S = self.gains(x)
        sizes = np.linalg.slogdet(S)[1]
        size = float(sizes.sum() * self.p / self.pieces.readings) if S.ndim == 3 else float(sizes)
        scale = float((self.whitened(S, e)**2).mean()) * float(np.exp(-size / self.p))
        return size + self.p * float(np.log(max(scale, 1e-300))), scale

    def improved(self, x: np.ndarray, B: np.ndarray, D: np.ndarray, starts: np.ndarray, tell: Tell) -> np.ndarray:
        """The x that is more likely, at these B, D and starts."""
        lost, most, made = np.full(self.pieces.readings, np.sqrt(WORST)), SEARCH * (len(x) + 1), counted()

        def cost(z: np.ndarray) -> np.ndarray:
            tell(next(made) / most)
            try:
                K, S = self.gains(z)
                e = prediction_errors(self.A, B, self.C, D, K, starts, self.pieces)
                return self.whitened(S, e).reshape(-1) if np.isfinite(e).all() else lost
            except (np.linalg.LinAlgError, ValueError):
                return lost
        return least_squares(cost, x, method="lm", x_scale=np.maximum(np.abs(x), 1e-3), diff_step=1e-5, xtol=1e-3, ftol=1e-5,
                             max_nfev=most).x

    def found(self, x: np.ndarray, B: np.ndarray, D: np.ndarray, starts: np.ndarray) -> NoiseFit:
        """Q and R with their scale."""
        K, _ = self.gains(x)
        e = prediction_errors(self.A, B, self.C, D, K, starts, self.pieces)
        level, scale = self.level(x, e)
        Q, R = self.noises(x)
        if self.pieces.seen is not None:
            e = np.where(self.pieces.seen, e, np.nan)[self.pieces.seen.any(axis=1)]
        return NoiseFit(symmetric(scale * Q), scale * R, B, D, starts, e, level + self.p)


def _answer(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray, u: np.ndarray) -> np.ndarray:
    """What must be taken off y so that the predictor with B = 0, D = 0 makes the errors of the one with B and D.

    By superposition e = e(y, 0) + e(0, u): (y, u) and (y − G u, 0) give the same errors, G u the answer of the plant itself.
    """
    x = affine_scan(A, u @ B.T, np.zeros(len(A)), len(u))[:-1]
    return x @ C.T + u @ D.T
