"""Compute optimal gains: LQR, Kalman–Bucy filter, and their discrete forms."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field, replace
from functools import cached_property

import numpy as np

from ..plotting import with_plot
from ..systems.arrays import as_checked, as_definite, as_weight, correlations, frozen, is_definite, symmetric
from ..systems.balance import MIN_RATE
from ..systems.errors import EngineError, RiccatiError, ShapeError, phrase
from ..systems.gates.argument_checks import matrix, takes
from ..systems.pole_sets import Poles, pole_text, sorted_poles
from ..systems.records import record
from ..systems.stability import all_stable
from .gain_record import ActsAsGain
from .riccati import solve_continuous, solve_discrete
from .riccati_problem import Equation, RiccatiProblem, in_balanced_units
from .singular_weight import solve_singular

__all__ = ["DiscreteFilter", "Optimal", "dlqe", "dlqr", "lqe", "lqr"]

PSD_TOLERANCE = 1e-10
RESIDUAL_LIMIT = 1e-6


@record()
class Optimal(ActsAsGain):
    """An optimal gain with its certificate; unpacks as `K, S, poles = lqr(…)` and acts as its gain.

    gain: K (m×n) or L (n×p). solution: S or P (n×n), symmetric. poles: closed-loop eigenvalues, sorted by (real, imag).
    """

    gain: np.ndarray
    solution: np.ndarray
    poles: Poles
    _equation: Equation = field(repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "poles", with_plot(self.poles))

    def __iter__(self) -> Iterator[np.ndarray]:
        return iter((self.gain, self.solution, self.poles))

    def __getitem__(self, place: int) -> np.ndarray:
        return (self.gain, self.solution, self.poles)[place]

    @cached_property
    def residual(self) -> float:
        """Frobenius norm of the Riccati residual of the solution as it stands, nothing rounded on the way, relative to the
        sum of the norms of its terms, in balanced states."""
        return self._equation.residual()


@record()
class DiscreteFilter(Optimal):
    """The steady Kalman filter in discrete time: gain is the predictor gain L, A·M unless w and v agree, filter_gain is M.

    Predictor: x̂⁺ = A x̂ + B u + L (y − C x̂ − D u), poles eig(A − LC). solution is the a-priori covariance P of x − x̂.
    Filter: x̂ after y is x̂ + M (y − C x̂ − D u), with covariance `filtered` = (I − MC) P.
    """

    filter_gain: np.ndarray
    filtered: np.ndarray

    @property
    def predictor_gain(self) -> np.ndarray:
        """L, the same as `gain`."""
        return self.gain


@takes("continuous", A=matrix(), B=matrix(), Q=matrix(), R=matrix(), N=matrix())
def lqr(A: object, B: object, Q: object, R: object, N: object | None = None) -> Optimal:
    """K = R⁻¹(BᵀS + Nᵀ) minimising ∫ xᵀQx + 2xᵀNu + uᵀRu dt for ẋ = Ax + Bu, u = −Kx.

    S ≥ 0 solves AᵀS + SA − (SB + N)R⁻¹(BᵀS + Nᵀ) + Q = 0. Shapes: A n×n, B n×m, Q n×n symmetric and positive
    semidefinite, R m×m symmetric and positive definite, N n×m. Raises ShapeError, EngineError for bad weights,
    RiccatiError where no stabilising gain exists.

    >>> np.round(lqr([[0, 1], [0, 0]], [[0], [1]], np.eye(2), [[1]]).gain, 4)
    array([[1.    , 1.7321]])
    """
    problem = _regulator(A, B, Q, R, N)
    return _solved(problem, 0.0, _CONTROL)


@takes("sampled", A=matrix(), B=matrix(), Q=matrix(), R=matrix(), N=matrix())
def dlqr(A: object, B: object, Q: object, R: object, N: object | None = None) -> Optimal:
    """K = (R + BᵀSB)⁻¹(BᵀSA + Nᵀ) minimising Σ xᵀQx + 2xᵀNu + uᵀRu for x⁺ = Ax + Bu, u = −Kx.

    S solves S = AᵀSA − (AᵀSB + N)(R + BᵀSB)⁻¹(BᵀSA + Nᵀ) + Q; A may be singular, and R where R + BᵀSB is
    not. Shapes and errors as `lqr`.

    >>> np.round(dlqr([[1]], [[1]], [[1]], [[1]]).gain, 4)
    array([[0.618]])
    """
    problem = _regulator(A, B, Q, R, N, as_weight)
    return _solved(problem, 1.0, _CONTROL)


@takes("continuous", A=matrix(), G=matrix(), C=matrix(), W=matrix(), V=matrix(), N=matrix())
def lqe(A: object, G: object, C: object, W: object, V: object, N: object | None = None) -> Optimal:
    """L = (PCᵀ + GN)V⁻¹ of the Kalman–Bucy filter for ẋ = Ax + Gw, y = Cx + v, white w, v of intensities W, V and N = E wvᵀ.

    P ≥ 0 solves AP + PAᵀ − (PCᵀ + GN)V⁻¹(CP + NᵀGᵀ) + GWGᵀ = 0. Shapes: A n×n, G n×q, C p×n, W q×q ≥ 0, V p×p > 0, N q×p
    (zero if left out). L depends on the ratio of W, N and V alone. Raises as `lqr` does.

    >>> np.round(lqe([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], [[1]], [[1]]).gain.T, 4)
    array([[1.4142, 1.    ]])
    """
    problem, noise = _estimator(A, G, C, W, V, N)
    dual = _solved(problem, 0.0, _ESTIMATION)
    return Optimal(frozen(dual.gain.T), dual.solution, dual.poles, replace(dual._equation, noise=noise))


@takes("sampled", A=matrix(), G=matrix(), C=matrix(), W=matrix(), V=matrix(), N=matrix())
def dlqe(A: object, G: object, C: object, W: object, V: object, N: object | None = None) -> DiscreteFilter:
    """Steady Kalman filter of x⁺ = Ax + Gw, y = Cx + v with covariances W, V and N = E wvᵀ: the gain L, and M = PCᵀ(CPCᵀ + V)⁻¹.

    L = (APCᵀ + GN)(CPCᵀ + V)⁻¹, which is A·M where N = 0, and P = APAᵀ − L(CPCᵀ + V)Lᵀ + GWGᵀ. V may be singular (sensors
    without noise) where CPCᵀ + V is not. Shapes and errors as `lqe`.

    >>> np.round(dlqe([[1]], [[1]], [[1]], [[1]], [[1]]).gain, 4)
    array([[0.618]])
    """
    problem, noise = _estimator(A, G, C, W, V, N, as_weight)
    dual = _solved(problem, 1.0, _ESTIMATION)
    P, C_, V_ = dual.solution, problem.B.T, problem.R
    M = np.linalg.solve(C_ @ P @ C_.T + V_, C_ @ P).T
    I_MC = np.eye(P.shape[0]) - M @ C_
    filtered = I_MC @ P @ I_MC.T + M @ V_ @ M.T
    return DiscreteFilter(
        frozen(dual.gain.T), P, dual.poles, replace(dual._equation, noise=noise), frozen(M), frozen(symmetric(filtered))
    )


@record(eq=True)
class _Words:
    hidden: str  # what an unstable mode must not be
    blind: str  # what a mode on the boundary must not be
    weight: str
    gain: str
    second: str


_CONTROL = _Words(phrase("uncontrollable"), phrase("the weight Q has no effect on it"), "Q", "K", "R")
_ESTIMATION = _Words(phrase("unobservable"), phrase("the noise w does not excite it"), "W", "L", "V")


def _regulator(A: object, B: object, Q: object, R: object, N: object | None,
               weight: Callable[[object, str, int], np.ndarray] = as_definite) -> RiccatiProblem:
    A, B = as_checked(A), as_checked(B)
    n = _square(A, "A")
    if B.shape[0] != n:
        raise ShapeError("B must have {n} rows, as A has; it is {rows}×{columns}.",
                         n=n, rows=B.shape[0], columns=B.shape[1])
    m = B.shape[1]
    Q, R = as_weight(Q, "Q", n), weight(R, "R", m)
    return RiccatiProblem(A, B, Q, R, _cross(N, n, m, Q, R))


def _estimator(A: object, G: object, C: object, W: object, V: object, N: object | None,
               weight: Callable[[object, str, int], np.ndarray] = as_definite) -> tuple[RiccatiProblem, tuple[np.ndarray, np.ndarray]]:
    A, G, C = as_checked(A), as_checked(G), as_checked(C)
    n = _square(A, "A")
    if G.shape[0] != n:
        raise ShapeError("G must have {n} rows, as A has; it is {rows}×{columns}.",
                         n=n, rows=G.shape[0], columns=G.shape[1])
    if C.shape[1] != n:
        raise ShapeError("C must have {n} columns, as A has; it is {rows}×{columns}.",
                         n=n, rows=C.shape[0], columns=C.shape[1])
    W, V = as_weight(W, "W", G.shape[1]), weight(V, "V", C.shape[0])
    both = _cross(N, G.shape[1], C.shape[0], W, V)
    noise = G @ W @ G.T
    return RiccatiProblem(A.T, C.T, symmetric(noise), V, G @ both), (G, W)


def _cross(N: object | None, rows: int, columns: int, Q: np.ndarray, R: np.ndarray) -> np.ndarray:
    """N (rows×columns), zero if left out, that fits between the weights Q and R."""
    cross = np.zeros((rows, columns)) if N is None else as_checked(N)
    if cross.shape != (rows, columns):
        raise ShapeError("N must be {n}×{m}; it is {rows}×{columns}.", n=rows, m=columns, rows=cross.shape[0], columns=cross.shape[1])
    if np.any(cross) and is_definite(R):
        _not_too_much(Q, R, cross)
    return cross


def _square(A: np.ndarray, name: str) -> int:
    if not A.size:
        raise ShapeError("The plant has no states, so there is no gain to design.")
    if A.shape[0] != A.shape[1]:
        raise ShapeError("{name} must be square; it is {rows}×{columns}.",
                         name=name, rows=A.shape[0], columns=A.shape[1])
    return A.shape[0]


def _not_too_much(Q: np.ndarray, R: np.ndarray, N: np.ndarray) -> None:
    """Q − N R⁻¹ Nᵀ must be positive semidefinite, in the units of Q's entries."""
    spread = correlations(Q)[1]
    rest = symmetric(Q - N @ np.linalg.solve(R, N.T)) / np.outer(spread, spread)
    if float(np.linalg.eigvalsh(rest)[0]) < -PSD_TOLERANCE * max(1.0, float(np.abs(rest).max())):
        raise EngineError("{name} has a negative eigenvalue; it must be positive semidefinite.", name="Q − N R⁻¹ Nᵀ")


def _solved(problem: RiccatiProblem, boundary: float, words: _Words) -> Optimal:
    """Solve, and check that the gain stabilises; `boundary` is 0 in continuous and 1 in discrete time."""
    if boundary and not is_definite(problem.R):
        found = solve_singular(problem)
        poles = sorted_poles(problem.A - problem.B @ found[1]) if found else np.ones(1)
        if found is None or found[2] > RESIDUAL_LIMIT or not all_stable(poles, dt=1.0):
            raise RiccatiError("With a singular {weight} no stabilising {gain} was found; make {weight} positive definite.",
                               weight=words.second, gain=words.gain)
        return Optimal(frozen(found[1]), frozen(found[0]), frozen(poles), Equation(problem, found[0], True))
    try:
        S, K, residual, poles = (solve_discrete if boundary else solve_continuous)(problem)
    except RiccatiError as failure:
        raise _diagnosis(problem, boundary, words) from failure
    if not (np.all(np.isfinite(S)) and residual < RESIDUAL_LIMIT):
        raise _diagnosis(problem, boundary, words)
    poles = np.sort_complex(poles)
    if np.any(_beyond(poles, boundary) >= 0):
        raise _diagnosis(problem, boundary, words)
    return Optimal(frozen(K), frozen(S), frozen(poles), Equation(problem, S, bool(boundary)))


def _beyond(poles: Poles, boundary: float) -> np.ndarray:
    """How far each pole lies beyond the stability boundary (negative: stable)."""
    return np.abs(poles) - 1.0 if boundary else poles.real


def _named(pole: complex, boundary: float) -> str:
    """A pole as an error says it: of a sampled model as z = …, which of a plant in continuous time is none of its own."""
    return ("z = " if boundary else "") + pole_text(pole)


def _diagnosis(problem: RiccatiProblem, boundary: float, words: _Words) -> RiccatiError:
    """The error that names the mode at fault, as far as it can be found."""
    problem = in_balanced_units(problem)[0]
    A, B, Q, N = problem.A, problem.B, problem.Q, problem.N
    n, scale = A.shape[0], max(1.0 if boundary else 0.0, float(np.linalg.norm(A, 2)))
    if not scale > MIN_RATE:
        scale = 1.0
    poles = np.linalg.eigvals(A).astype(complex)
    for pole in poles[_beyond(poles, boundary) > -1e-9 * scale]:
        shifted = A - pole * np.eye(n)
        if _deficient(np.hstack([shifted / scale, B / max(float(np.linalg.norm(B, 2)), 1e-300)])):
            return RiccatiError("The mode at {pole} is not stable and is {hidden}: no {gain} can stabilise it; change the "
                                "plant.", pole=_named(pole, boundary), hidden=words.hidden, gain=words.gain)
    A_bar = A - B @ np.linalg.solve(problem.R, N.T)
    Q_bar = Q - N @ np.linalg.solve(problem.R, N.T)
    poles = np.linalg.eigvals(A_bar).astype(complex)
    for pole in poles[np.abs(_beyond(poles, boundary)) <= 1e-6 * scale]:
        shifted = A_bar - pole * np.eye(n)
        if _deficient(np.vstack([shifted / scale, Q_bar / max(float(np.linalg.norm(Q_bar, 2)), 1e-300)])):
            return RiccatiError("The mode at {pole} lies on the stability boundary and {blind}: make {weight} act on it.",
                                pole=_named(pole, boundary), blind=words.blind, weight=words.weight)
    return RiccatiError("The Riccati equation is too ill-conditioned to be solved; bring the weights or the units of the "
                        "states closer.")


def _deficient(matrix: np.ndarray) -> bool:
    return bool(np.linalg.svd(matrix, compute_uv=False)[-1] < 1e-8)
