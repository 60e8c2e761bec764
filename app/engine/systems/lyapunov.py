"""Solve Lyapunov equations by square-root factors, so that variances stay positive."""

from __future__ import annotations

import warnings
from functools import lru_cache

import numpy as np
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov
from scipy.linalg.lapack import dgees, dgeqrf, dtrsyl  # pyright: ignore[reportAttributeAccessIssue]

from .arrays import correlations, frozen, symmetric
from .balance import balance, plain_scale
from .errors import EngineError
from .gates.argument_checks import PERIOD, matrix, takes
from .records import record

__all__ = ["lyapunov_solution", "settled_covariance", "settled_factor"]

EPS = float(np.finfo(float).eps)
UNEVEN = 1e-4  # deviations further apart than this, in balanced states, cost the small ones digits
ALIKE = 2.0  # bits between the scales of a plant and those of its dual
DIM = 1e-7  # squares tell deviations down to this share of the largest
STIFF, FEW = 1e5, 60  # ratio of the rates; states up to which they are asked for
MAX_FACTOR = 1e150  # a factor as large as this has variances that overflow


@takes(A=matrix("n n"), G=matrix("n q"), dt=PERIOD)
def settled_covariance(A: np.ndarray, G: np.ndarray, *, dt: float = 0.0) -> np.ndarray:
    """P (n×n) ⪰ 0 with A P + P Aᵀ + G Gᵀ = 0, or A P Aᵀ − P + G Gᵀ = 0 where dt > 0, for stable A n×n and G n×q."""
    return _covariance(A, G, settled_factor(A, G, dt), _is_stiff(A, dt))


def settled_covariances(A: np.ndarray, B: np.ndarray, C: np.ndarray, dt: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Both Gramians of a stable plant (n×n)."""
    Rc, Ro = settled_factors(A, B, C, dt)
    stiff = _is_stiff(A, dt)
    return _covariance(A, B, Rc, stiff), _covariance(A.T, C.T, Ro, stiff)


def _covariance(A: np.ndarray, G: np.ndarray, R: np.ndarray, stiff: bool) -> np.ndarray:
    exact = _substituted(A, G) if stiff else None
    return R.dot(R.T) if exact is None else exact


def _is_stiff(A: np.ndarray, dt: float) -> bool:
    """Whether rates are so far apart that the transform behind the factor costs digits."""
    if dt or not 1 < len(A) <= FEW:
        return False
    rates = np.abs(np.linalg.eigvals(A))
    return bool(STIFF * rates.min() < rates.max())


def _substituted(A: np.ndarray, G: np.ndarray) -> np.ndarray | None:
    """The solution by back substitution where it is positive definite; else None."""
    try:
        X = symmetric(lyapunov_solution(A, G @ G.T))
        np.linalg.cholesky(correlations(X)[0])
    except np.linalg.LinAlgError:
        return None
    return X


def lyapunov_solution(A: np.ndarray, Q: np.ndarray, dt: float = 0.0) -> np.ndarray:
    """X (n×n) of A X + X Aᵀ + Q = 0, or A X Aᵀ − X + Q = 0 where dt > 0, for any A with one solution and any Q.

    In states balanced with what Q drives, again in those of the deviations √|X_ii| where these are far apart, and with one step of
    refinement. Raises LinAlgError where double precision finds more than one solution.
    """
    if not Q.any():
        return np.zeros_like(Q)
    size = 2.0 ** np.round(np.log2(np.abs(Q).max()))
    scale = balance(A, np.sqrt(np.abs(np.diag(Q)) / size)[:, None]).states
    X = _solved(A, Q / size, scale, dt)
    spread = np.sqrt(np.abs(np.diag(X)))
    if 0 < spread.min() < UNEVEN * spread.max():
        scale = _units(scale, spread)
        X = _solved(A, Q / size, scale, dt)
    return size * (X * scale * scale[:, None])


def _solved(A: np.ndarray, Q: np.ndarray, scale: np.ndarray, dt: float) -> np.ndarray:
    """X in scaled states."""
    F, forcing = A * scale / scale[:, None], Q / scale / scale[:, None]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            X = _direct(F, forcing, dt)
            return X + _direct(F, F @ X @ F.T - X + forcing if dt else F @ X + X @ F.T + forcing, dt)
        except (RuntimeWarning, ValueError) as problem:  # SciPy's words for a pair of poles that adds up to zero, or for overflow
            raise np.linalg.LinAlgError from problem


def _direct(A: np.ndarray, Q: np.ndarray, dt: float) -> np.ndarray:
    return solve_discrete_lyapunov(A, Q) if dt else solve_continuous_lyapunov(A, -Q)


def settled_factor(A: np.ndarray, G: np.ndarray, dt: float = 0.0) -> np.ndarray:
    """R (n×n) with R Rᵀ the solution of `settled_covariance`, in states balanced with what drives them.

    Many states are balanced as LAPACK does it. Where the deviations that come out are far apart they are the better units: it is found
    in those. Squares tell them beforehand
    as far as squares can; where a factor shows them too late it is done again.
    Raises EngineError where a power of A grows.
    """
    if not len(A):
        return np.zeros((0, 0))
    scales = _driven(A, G), plain_scale(A)
    first, second = reversed(scales) if len(A) > FEW else scales  # what drives one end of a chain says too much of the other
    return _tried(A, G, dt, first, _Triangular.of(A, G, first), second)


def settled_factors(A: np.ndarray, B: np.ndarray, C: np.ndarray, dt: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """The factors of both Gramians, of (A, B) and of (Aᵀ, Cᵀ), in one Schur form where inputs and outputs balance the states alike."""
    states, seen = _driven(A, B), _driven(A.T, C.T)
    if not len(A) or np.ptp(np.log2(states * seen)) > ALIKE:
        return settled_factor(A, B, dt), settled_factor(A.T, C.T, dt)
    pair = _Triangular.of(A, B, states)
    plain = plain_scale(A)
    return (_tried(A, B, dt, states, pair, plain),
            _tried(A.T, C.T, dt, 1 / states, pair.dual(C.T * states[:, None]), 1 / plain))


def _driven(A: np.ndarray, G: np.ndarray) -> np.ndarray:
    """The scales of states that G drives."""
    return balance(A, np.linalg.norm(G, axis=1)[:, None]).states


def _tried(A: np.ndarray, G: np.ndarray, dt: float, scale: np.ndarray, pair: _Triangular, otherwise: np.ndarray) -> np.ndarray:
    try:
        return _factor(A, G, dt, scale, pair)
    except EngineError:  # powers that grow in the one scale need not in the other
        return _factor(A, G, dt, otherwise, _Triangular.of(A, G, otherwise))


def _factor(A: np.ndarray, G: np.ndarray, dt: float, scale: np.ndarray, pair: _Triangular) -> np.ndarray:
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

    def dual(self, G: np.ndarray) -> _Triangular:
        """Of Aᵀ, driven by G in its scaled states: the same form read backwards."""
        Z = self.Z[:, ::-1]
        return _Triangular(np.asfortranarray(self.T.T[::-1, ::-1]), Z, Z.T @ G, self.sizes[::-1])

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
                if R.shape[1] > n:
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
    if not R.size:
        return R
    found = dgeqrf(R.T, lwork=64 * len(R))[0][:min(R.shape)].T
    return found * _lower(*found.shape)


@lru_cache(maxsize=64)
def _lower(rows: int, columns: int) -> np.ndarray:
    """Ones on the diagonal and below it."""
    return frozen(np.tri(rows, columns))
