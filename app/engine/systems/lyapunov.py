"""Lyapunov's equations by square-root factors in balanced states: variances that cannot come out negative."""

from __future__ import annotations

import numpy as np
from scipy.linalg import schur

from .balance import balance
from .errors import EngineError

__all__ = ["settled_covariance", "settled_factor"]

EPS = float(np.finfo(float).eps)
UNEVEN = 1e-4  # deviations further apart than this, in balanced states, cost the small ones digits
WIDE = 4  # times as many columns as states, before a factor is compressed
LARGEST = 1e150  # a factor as large as this has variances that overflow


def settled_covariance(A: np.ndarray, G: np.ndarray, *, dt: float = 0.0) -> np.ndarray:
    """P (n×n) ⪰ 0 with A P + P Aᵀ + G Gᵀ = 0, or A P Aᵀ − P + G Gᵀ = 0 where dt > 0, for stable A n×n and G n×q."""
    R = settled_factor(A, G, dt)
    return R @ R.T


def settled_factor(A: np.ndarray, G: np.ndarray, dt: float = 0.0) -> np.ndarray:
    """R (n×n) with R Rᵀ the solution of `settled_covariance`, in states balanced with what drives them.

    Where the deviations that come out are still far apart they are the better units, and it is done again in those.
    Raises EngineError where a power of A grows.
    """
    if not len(A):
        return np.zeros((0, 0))
    scale = balance(A, np.linalg.norm(G, axis=1)[:, None]).states
    R = _factor(A * scale / scale[:, None], G / scale[:, None], dt)
    spread = np.linalg.norm(R, axis=1)
    if 0 < spread.min() < UNEVEN * spread.max():
        scale = scale * 2.0 ** np.round(np.log2(spread))
        R = _factor(A * scale / scale[:, None], G / scale[:, None], dt)
    return scale[:, None] * R


def _factor(A: np.ndarray, G: np.ndarray, dt: float) -> np.ndarray:
    """R ← [R, A^(2^k) R], compressed orthogonally each time, in coordinates in which A is block triangular (Schur): its
    powers stay so, and no rounding below the diagonal makes them grow. Smith, "Matrix equation XA + BX = C" (1968)."""
    power, turn = schur(A, output="real")  # pyright: ignore[reportAssignmentType]
    R = turn.T @ G
    if dt == 0:
        power, R = _to_discrete(power, R)
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(64):
            more = power @ R
            added = np.vdot(more, more)
            if added <= EPS**2 * np.vdot(R, R):
                break
            if not added < LARGEST**2:
                raise EngineError("Rounding hides whether the loop is stable, so its variances cannot be told; choose gentler "
                                  "gains or other units.")
            R = np.hstack([R, more])
            if R.shape[1] > WIDE * len(A):
                R = _compress(R)
            power = power @ power
    R = _compress(R)
    return np.pad(turn @ R, ((0, 0), (0, len(A) - R.shape[1])))


def _to_discrete(A: np.ndarray, B: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cayley transform: a discrete pair with the same solution; poles of size α go to 0."""
    sizes = np.abs(np.linalg.eigvals(A))
    alpha = float(np.sqrt(sizes.min() * sizes.max()))
    solved = np.linalg.solve(alpha * np.eye(A.shape[0]) - A, np.hstack([A + alpha * np.eye(A.shape[0]), B]))
    return solved[:, :A.shape[0]], np.sqrt(2 * alpha) * solved[:, A.shape[0]:]


def _compress(R: np.ndarray) -> np.ndarray:
    """A factor of R Rᵀ with no more columns than rows."""
    return np.transpose(np.linalg.qr(R.T, mode="r")) if R.size else R  # pyright: ignore[reportArgumentType, reportCallIssue]
