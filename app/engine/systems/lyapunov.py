"""Solve Lyapunov equations by square-root factors, so that variances stay positive."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgees, dgeqrf, dtrsyl  # pyright: ignore[reportAttributeAccessIssue]

from .balance import balance
from .errors import EngineError
from .gates.argument_checks import PERIOD, matrix, takes
from .records import record

__all__ = ["settled_covariance", "settled_factor"]

EPS = float(np.finfo(float).eps)
UNEVEN = 1e-4  # deviations further apart than this, in balanced states, cost the small ones digits
DIM = 1e-7  # squares tell deviations down to this share of the largest
MAX_FACTOR_WIDTH = 4  # times as many columns as states, before a factor is compressed
MAX_FACTOR = 1e150  # a factor as large as this has variances that overflow


@takes(A=matrix("n n"), G=matrix("n q"), dt=PERIOD)
def settled_covariance(A: np.ndarray, G: np.ndarray, *, dt: float = 0.0) -> np.ndarray:
    """P (n×n) ⪰ 0 with A P + P Aᵀ + G Gᵀ = 0, or A P Aᵀ − P + G Gᵀ = 0 where dt > 0, for stable A n×n and G n×q."""
    R = settled_factor(A, G, dt)
    return R @ R.T


def settled_factor(A: np.ndarray, G: np.ndarray, dt: float = 0.0) -> np.ndarray:
    """R (n×n) with R Rᵀ the solution of `settled_covariance`, in states balanced with what drives them.

    Where the deviations that come out are far apart they are the better units: it is found in those. Squares tell them beforehand
    as far as squares can; where a factor shows them too late it is done again.
    Raises EngineError where a power of A grows.
    """
    if not len(A):
        return np.zeros((0, 0))
    scale = balance(A, np.linalg.norm(G, axis=1)[:, None]).states
    pair = _Triangular.of(A, G, scale)
    spread = pair.deviations() if dt == 0 else None
    if spread is not None and DIM * spread.max() < spread.min() < UNEVEN * spread.max():
        scale = _units(scale, spread)
        pair = _Triangular.of(A, G, scale)
    R = pair.factor(dt)
    spread = np.linalg.norm(R, axis=1)
    if 0 < spread.min() < UNEVEN * spread.max():
        scale = _units(scale, spread)
        R = _Triangular.of(A, G, scale).factor(dt)
    return scale[:, None] * R


def _units(scale: np.ndarray, spread: np.ndarray) -> np.ndarray:
    return scale * 2.0 ** np.round(np.log2(spread))


@record()
class _Triangular:
    """A = Z T Zᵀ (real Schur form) and Zᵀ G in scaled states; `sizes` are |λ|."""

    T: np.ndarray
    Z: np.ndarray
    G: np.ndarray
    sizes: np.ndarray

    @staticmethod
    def of(A: np.ndarray, G: np.ndarray, scale: np.ndarray) -> _Triangular:
        T, _, real, imag, Z, _, failure = dgees(_unsorted, A * scale / scale[:, None])
        if failure:
            raise np.linalg.LinAlgError
        return _Triangular(T, Z, Z.T @ (G / scale[:, None]), np.hypot(real, imag))

    def deviations(self) -> np.ndarray | None:
        """Square roots of the variances by Bartels and Stewart, which lose those below √ε of the largest; None where they overflow."""
        P, shrunk, _ = dtrsyl(self.T, self.T, self.G @ self.G.T, tranb="T")
        with np.errstate(over="ignore", invalid="ignore"):
            squares = -((self.Z @ P) * self.Z).sum(axis=1) / shrunk
        return np.sqrt(np.maximum(squares, 0.0)) if np.isfinite(squares).all() else None

    def factor(self, dt: float) -> np.ndarray:
        """R ← [R, A^(2^k) R], compressed orthogonally each time, in coordinates in which A is block triangular: its powers
        stay so, and no rounding below the diagonal makes them grow. Smith, "Matrix equation XA + BX = C" (1968)."""
        power, R, n = self.T, self.G, len(self.T)
        if dt == 0:
            power, R = self._to_discrete()
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(64):
                more = power @ R
                added = np.vdot(more, more)
                if added <= EPS**2 * np.vdot(R, R):
                    break
                if not added < MAX_FACTOR**2:
                    raise EngineError("Rounding hides whether the loop is stable, so its variances cannot be computed; choose smaller "
                                      "gains or other units.")
                R = np.concatenate([R, more], axis=1)
                if R.shape[1] > MAX_FACTOR_WIDTH * n:
                    R = _compress(R)
                power = power @ power
        found = self.Z @ _compress(R)
        return found if found.shape[1] == n else np.concatenate([found, np.zeros((n, n - found.shape[1]))], axis=1)

    def _to_discrete(self) -> tuple[np.ndarray, np.ndarray]:
        """Cayley transform: a discrete pair with the same solution; poles of size α go to 0."""
        n, alpha = len(self.T), float(np.sqrt(self.sizes.min() * self.sizes.max()))
        moved = alpha * np.eye(n)
        solved = np.linalg.solve(moved - self.T, np.concatenate([self.T + moved, self.G], axis=1))
        return solved[:, :n], np.sqrt(2 * alpha) * solved[:, n:]


def _unsorted(*_: float) -> None:
    """The order of the poles in a Schur form that nobody sorts."""


def _compress(R: np.ndarray) -> np.ndarray:
    """A factor of R Rᵀ with no more columns than rows."""
    return np.tril(dgeqrf(R.T)[0][:min(R.shape)].T) if R.size else R
