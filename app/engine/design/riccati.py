"""Solve Riccati equations at unit scale, refine by Newton steps, certify by the residual."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import suppress

import numpy as np
from scipy.linalg import (
    LinAlgWarning,
    solve_continuous_are,
    solve_discrete_are,
)
from scipy.linalg.lapack import dgees, dgeev, dgesv, dtrsyl  # pyright: ignore[reportAttributeAccessIssue]

from ..systems.arrays import symmetric
from ..systems.balance import plain_scale
from ..systems.errors import RiccatiError
from .riccati_problem import RiccatiProblem, in_balanced_units, norm, unit_scale

__all__ = ["continuous_residual", "discrete_residual", "solve_continuous", "solve_discrete"]

NEWTON_STEPS = 4  # at most; none or one nearly always does
GOOD_RESIDUAL = 2e-15  # and what rounding of that many states allows
EPS = float(np.finfo(float).eps)
DOUBTFUL = 1e8  # condition of R beyond which the Hamiltonian matrix is not trusted
DOUBLINGS = 50  # of the steps that a loop is followed for: poles to within 1e-13 of the circle
WELL = 1e6  # condition of A up to which the symplectic matrix, which needs its inverse, is trusted
SAME_POLE_RTOL = 1e-3  # relative difference of two poles that are the same
SAME_SCALES = 12  # bits: beyond it a solution is polished in the scales of A alone too
FAIR_RESIDUAL = 1e-13  # above it the equation is solved once more, from another beginning


Found = tuple[np.ndarray, np.ndarray, float]  # S, K and the relative residual
Solution = tuple[np.ndarray, np.ndarray, float, np.ndarray]  # and the poles of A − BK
Newton = Callable[[RiccatiProblem, np.ndarray, np.ndarray], np.ndarray]
Quick = Callable[[RiccatiProblem], tuple[np.ndarray, float] | None]
Evaluate = Callable[[RiccatiProblem, np.ndarray], tuple[np.ndarray, float, np.ndarray]]


def continuous_residual(problem: RiccatiProblem, S: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Residual AᵀS + SA + Q − KᵀRK, its norm relative to the sum of the norms of its terms, and K = R⁻¹(BᵀS + Nᵀ)."""
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    K = solved(R, B.T.dot(S) + N.T)
    SA = S.dot(A)
    quadratic = K.T.dot(R).dot(K)
    residual = SA + SA.T + Q - quadratic
    return residual, _relative(residual, 2 * norm(SA), Q, quadratic), K


def discrete_residual(problem: RiccatiProblem, S: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Residual AᵀSA − S + Q − Kᵀ(R + BᵀSB)K, its relative norm, and K = (R + BᵀSB)⁻¹(BᵀSA + Nᵀ)."""
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    BS = B.T @ S
    weight = R + BS @ B
    K = np.linalg.solve(weight, BS @ A + N.T)
    ASA, quadratic = A.T @ S @ A, K.T @ weight @ K
    residual = ASA - S + Q - quadratic
    return residual, _relative(residual, norm(S) + norm(ASA), Q, quadratic), K


def _relative(residual: np.ndarray, size: float, *terms: np.ndarray) -> float:
    total = size + sum(map(norm, terms))
    return norm(residual) / total if total > 0 else 0.0


def solve_continuous(problem: RiccatiProblem) -> Solution:
    """Stabilising S, K, the relative residual of the CARE and the poles of A − BK. Raises RiccatiError where there is none."""

    def newton(p: RiccatiProblem, K: np.ndarray, residual: np.ndarray) -> np.ndarray:
        return lyapunov((p.A - p.B.dot(K)).T, -residual)

    return _solve(problem, solve_continuous_are, newton, continuous_residual, by_hamiltonian,
                  lambda poles: -float(np.real(poles).max()))


def by_hamiltonian(problem: RiccatiProblem) -> tuple[np.ndarray, float] | None:
    """S from the stable invariant subspace of the Hamiltonian matrix, and |Re λ| of its slowest pole; None where there is doubt.

    Takes a third of the time of SciPy's pencil, which needs no R⁻¹. A double pole on the imaginary axis is split by rounding:
    then the slowest pole of A − BK is another one. Raises LinAlgError where S does not exist.
    """
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    n, drift = len(A), _drift(B, R, N)
    if drift is None:
        return None
    H = np.empty((2 * n, 2 * n), order="F")
    H[:n, :n] = A - B.dot(drift[:, n:])
    H[:n, n:], H[n:, :n], H[n:, n:] = -B.dot(drift[:, :n]), N.dot(drift[:, n:]) - Q, -H[:n, :n].T
    _, stable, real, _, U, _, failure = dgees(_is_stable, H, sort_t=1)
    if failure or stable != n:
        return None
    return symmetric(solved(U[:n, :n].T, U[n:, :n].T)), float(np.abs(real).min())


def solved(M: np.ndarray, right: np.ndarray) -> np.ndarray:
    """X (n×k) of M X = right by elimination, without what NumPy adds for a small M. Raises LinAlgError."""
    *_, X, failure = dgesv(M, right)
    if failure:
        raise np.linalg.LinAlgError
    return X


def _drift(B: np.ndarray, R: np.ndarray, N: np.ndarray) -> np.ndarray | None:
    """R⁻¹(Bᵀ, Nᵀ); None where R is too near to a singular matrix."""
    n, m = B.shape
    found = solved(R, np.concatenate([B.T, N.T, np.eye(m)], axis=1))
    return found[:, :2 * n] if norm(R) * norm(found[:, 2 * n:]) < DOUBTFUL else None


def by_symplectic(problem: RiccatiProblem) -> tuple[np.ndarray, float] | None:
    """The same in discrete time, from the symplectic matrix, with 1 − |λ| of the slowest pole; None too where A − BR⁻¹Nᵀ has no
    good inverse."""
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    n, drift = len(A), _drift(B, R, N)
    if drift is None:
        return None
    F = A - B @ drift[:, n:]
    back = np.linalg.inv(F).T
    if not norm(F) * norm(back) < WELL:
        return None
    late, costs = B @ drift[:, :n] @ back, Q - N @ drift[:, n:]
    _, stable, real, imag, U, _, failure = dgees(_is_inside, np.block([[F + late @ costs, -late], [-back @ costs, back]]), sort_t=1)
    if failure or stable != n:
        return None
    return symmetric(np.linalg.solve(U[:n, :n].T, U[n:, :n].T)), 1 - float(np.hypot(real[:n], imag[:n]).max())


def lyapunov(M: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """X of M X + X Mᵀ = Q, by Schur's form of M and back substitution. Raises LinAlgError where M and −M share a pole."""
    T, _, _, _, U, _, failure = dgees(_is_stable, M)
    X, scale, singular = dtrsyl(T, T, U.T.dot(Q).dot(U), tranb="T")
    if failure or singular:
        raise np.linalg.LinAlgError
    return U.dot(X / scale).dot(U.T)


def summed(M: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """X = Q + MᵀXM = Σ (Mᵀ)ᵏ Q Mᵏ, by doubling: SciPy's bilinear map loses six digits more where M is large. Raises LinAlgError for
    an M that is not stable."""
    X, least = Q, 1e-20 * norm(Q)
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(DOUBLINGS):
            more = M.T @ X @ M
            X, M = X + more, M @ M
            if norm(more) <= least:
                return X
    raise np.linalg.LinAlgError


def _is_stable(real: float, imag: float) -> bool:
    return real < 0


def _is_inside(real: float, imag: float) -> bool:
    return real * real + imag * imag < 1


def solve_discrete(problem: RiccatiProblem) -> Solution:
    """Stabilising S, K, the relative residual of the DARE and the poles of A − BK; by SciPy's extended pencil for an A nearly singular."""

    def newton(p: RiccatiProblem, K: np.ndarray, residual: np.ndarray) -> np.ndarray:
        return summed(p.A - p.B @ K, residual)

    return _solve(problem, solve_discrete_are, newton, discrete_residual, by_symplectic,
                  lambda poles: 1 - float(np.abs(poles).max()))


def _solve(
    problem: RiccatiProblem,
    library: Callable[..., np.ndarray],
    newton: Newton,
    evaluate: Evaluate,
    quick: Quick,
    inside: Callable[[np.ndarray], float],
) -> Solution:
    plain, first_cost, first_input = unit_scale(problem)  # a common factor of the weights changes not even a bit
    own, states, inputs = in_balanced_units(plain)
    scaled, cost_scale, input_scale = unit_scale(own)
    cost_scale, input_scale = first_cost * cost_scale, first_input * input_scale
    x = plain_scale(plain.A) / states
    apart = x.max() >= 2.0**SAME_SCALES * x.min()
    quickly = _quickly(scaled, newton, evaluate, quick, inside)
    best = (quickly[:3] if quickly is not None else
            _thoroughly(scaled, library, newton, evaluate, (True,) if apart else (True, False)))
    if apart:  # where weights and drift pull a scale apart, what is small in the one is not in the other
        best = _in_other_states(x, scaled, best, library, newton, evaluate)
    if best is None:
        raise RiccatiError("The Riccati equation has no stabilising solution; change the weights or the plant.")
    S, K, size = best
    poles = quickly[3] if quickly is not None and K is quickly[1] else np.linalg.eigvals(scaled.A - scaled.B @ K)
    return cost_scale * S / states / states[:, None], input_scale * K * inputs[:, None] / states, size, poles


def _quickly(problem: RiccatiProblem, newton: Newton, evaluate: Evaluate, quick: Quick,
             inside: Callable[[np.ndarray], float]) -> Solution | None:
    """By our own subspace, None where there is doubt."""
    with suppress(np.linalg.LinAlgError):
        if (guess := quick(problem)) is not None:
            residual, _, K = evaluate(problem, guess[0])  # a first step in any case: it keeps apart what the plant keeps apart
            found = _polished(problem, symmetric(guess[0] + newton(problem, K, residual)), newton, evaluate)
            real, imag, *_, failure = dgeev(problem.A - problem.B.dot(found[1]), compute_vl=0, compute_vr=0)
            if failure:
                return None
            poles = real + 1j * imag
            slowest = inside(poles)
            return (*found, poles) if found[2] < _good(problem) and abs(slowest - guess[1]) <= SAME_POLE_RTOL * guess[1] else None
    return None


def _thoroughly(problem: RiccatiProblem, library: Callable[..., np.ndarray], newton: Newton, evaluate: Evaluate,
                ways: tuple[bool, ...] = (True, False)) -> Found | None:
    """By SciPy's pencil; where its balancing makes its reordering fail, we do without. What it found is judged by its residual."""
    best = None
    for balanced in ways:
        with suppress(np.linalg.LinAlgError, ValueError), warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore", LinAlgWarning)
            S = library(problem.A, problem.B, problem.Q, problem.R, s=problem.N if np.any(problem.N) else None, balanced=balanced)
            found = _polished(problem, symmetric(S), newton, evaluate)
            best = found if best is None or found[2] < best[2] else best
            if best[2] < FAIR_RESIDUAL:
                break
    return best


def _in_other_states(x: np.ndarray, problem: RiccatiProblem, best: Found | None, library: Callable[..., np.ndarray], newton: Newton,
                     evaluate: Evaluate) -> Found | None:
    """The solution polished in states scaled by x (n,), or found there where it was not found, if it is no worse."""
    turned = RiccatiProblem(problem.A * x / x[:, None], problem.B / x[:, None], problem.Q * x * x[:, None], problem.R,
                            problem.N * x[:, None])
    known = best is not None and best[2] < FAIR_RESIDUAL
    other = _polished(turned, best[0] * x * x[:, None], newton, evaluate) if known else _thoroughly(turned, library, newton, evaluate)
    if other is None:
        return best
    S = other[0] / x / x[:, None]
    _, size, K = evaluate(problem, S)
    if known:
        return (S, K, size) if size <= max(best[2], GOOD_RESIDUAL) else best
    return (S, other[1] / x, other[2]) if best is None or other[2] < best[2] else best


def _good(problem: RiccatiProblem) -> float:
    return max(GOOD_RESIDUAL, len(problem.A) * EPS)


def _polished(problem: RiccatiProblem, S: np.ndarray, newton: Newton, evaluate: Evaluate) -> Found:
    """S after Newton's steps, as long as they help, its K and relative residual."""
    residual, size, K = evaluate(problem, S)
    for _ in range(NEWTON_STEPS):
        if size < _good(problem):
            break
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                better = symmetric(S + newton(problem, K, residual))
            new_residual, new_size, new_K = evaluate(problem, better)
        except (np.linalg.LinAlgError, ValueError, RuntimeWarning, LinAlgWarning):
            break
        if not new_size < size:
            break
        S, residual, size, K = better, new_residual, new_size, new_K
    return S, K, size
