"""Riccati equations at unit scale, polished by Newton steps and certified by their residual."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.linalg import (
    LinAlgWarning,
    solve_continuous_are,
    solve_continuous_lyapunov,
    solve_discrete_are,
    solve_discrete_lyapunov,
)

from ..systems.arrays import symmetric
from ..systems.balance import state_scale
from ..systems.errors import RiccatiError

__all__ = ["RiccatiProblem", "continuous_residual", "discrete_residual", "solve_continuous", "solve_discrete"]

NEWTON_STEPS = 4  # at most; none or one nearly always does
GOOD_RESIDUAL = 2e-15
FAIR_RESIDUAL = 1e-13  # above it the equation is solved once more, from another beginning


@dataclass(frozen=True, eq=False)
class RiccatiProblem:
    """The data of min ∫ xᵀQx + 2xᵀNu + uᵀRu (or the sum, in discrete time) along ẋ = Ax + Bu."""

    A: np.ndarray
    B: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    N: np.ndarray


def continuous_residual(problem: RiccatiProblem, S: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Residual AᵀS + SA + Q − KᵀRK, its norm relative to the sum of the norms of its terms, and K = R⁻¹(BᵀS + Nᵀ)."""
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    K = np.linalg.solve(R, B.T @ S + N.T)
    SA = S @ A
    quadratic = K.T @ R @ K
    residual = SA + SA.T + Q - quadratic
    return residual, _relative(residual, 2 * np.linalg.norm(SA), Q, quadratic), K


def discrete_residual(problem: RiccatiProblem, S: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Residual AᵀSA − S + Q − Kᵀ(R + BᵀSB)K, its relative norm, and K = (R + BᵀSB)⁻¹(BᵀSA + Nᵀ)."""
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    BS = B.T @ S
    weight = R + BS @ B
    K = np.linalg.solve(weight, BS @ A + N.T)
    ASA, quadratic = A.T @ S @ A, K.T @ weight @ K
    residual = ASA - S + Q - quadratic
    return residual, _relative(residual, np.linalg.norm(S) + np.linalg.norm(ASA), Q, quadratic), K


def _relative(residual: np.ndarray, size: float | np.floating, *terms: np.ndarray) -> float:
    total = float(size) + sum(float(np.linalg.norm(term)) for term in terms)
    return float(np.linalg.norm(residual)) / total if total > 0 else 0.0


def solve_continuous(problem: RiccatiProblem) -> tuple[np.ndarray, np.ndarray, float]:
    """Stabilising S, K and the relative residual of the CARE. Raises RiccatiError where there is none."""

    def newton(p: RiccatiProblem, K: np.ndarray, residual: np.ndarray) -> np.ndarray:
        return solve_continuous_lyapunov((p.A - p.B @ K).T, -residual)

    return _solve(problem, solve_continuous_are, newton, continuous_residual)


def solve_discrete(problem: RiccatiProblem) -> tuple[np.ndarray, np.ndarray, float]:
    """Stabilising S, K and the relative residual of the DARE (A may be singular: SciPy's extended pencil)."""

    def newton(p: RiccatiProblem, K: np.ndarray, residual: np.ndarray) -> np.ndarray:
        return solve_discrete_lyapunov((p.A - p.B @ K).T, residual)

    return _solve(problem, solve_discrete_are, newton, discrete_residual)


def _solve(
    problem: RiccatiProblem,
    library: Callable[..., np.ndarray],
    newton: Callable[[RiccatiProblem, np.ndarray, np.ndarray], np.ndarray],
    evaluate: Callable[[RiccatiProblem, np.ndarray], tuple[np.ndarray, float, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray, float]:
    plain, first_cost, first_input = unit_scale(problem)  # a common factor of the weights changes not even a bit
    own, states, inputs = in_balanced_units(plain)
    scaled, cost_scale, input_scale = unit_scale(own)
    cost_scale, input_scale = first_cost * cost_scale, first_input * input_scale
    best = None
    for balanced in (True, False):  # where SciPy's own balancing makes its reordering of the pencil fail, we do without
        with suppress(np.linalg.LinAlgError, ValueError):
            S = library(scaled.A, scaled.B, scaled.Q, scaled.R, s=scaled.N if np.any(scaled.N) else None, balanced=balanced)
            found = _polished(scaled, symmetric(S), newton, evaluate)
            best = found if best is None or found[2] < best[2] else best
            if best[2] < FAIR_RESIDUAL:
                break
    if best is None:
        raise RiccatiError("The Riccati equation has no stabilising solution; change the weights or the plant.")
    S, K, size = best
    return cost_scale * S / states / states[:, None], input_scale * K * inputs[:, None] / states, size


def _polished(
    problem: RiccatiProblem, S: np.ndarray, newton: Callable[[RiccatiProblem, np.ndarray, np.ndarray], np.ndarray],
    evaluate: Callable[[RiccatiProblem, np.ndarray], tuple[np.ndarray, float, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray, float]:
    """S after Newton's steps, as long as they help, its K and relative residual."""
    residual, size, K = evaluate(problem, S)
    for _ in range(NEWTON_STEPS):
        if size < GOOD_RESIDUAL:
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


def in_balanced_units(problem: RiccatiProblem) -> tuple[RiccatiProblem, np.ndarray, np.ndarray]:
    """The same problem in balanced states and in inputs of like weight, with the scales of both, powers of two.

    What pins the scales beside A are how strongly an input of unit cost drives a state, and what a state costs.
    """
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    inputs = 2.0 ** -np.round(np.log2(np.diag(R)) / 2)
    driven = np.linalg.norm(B * inputs, axis=1)[:, None]
    x = state_scale(A, driven, np.sqrt(np.maximum(np.diag(Q), 0.0))[None])
    return RiccatiProblem(A * x / x[:, None], B * inputs / x[:, None], Q * x * x[:, None], R * inputs * inputs[:, None],
                          N * inputs * x[:, None]), x, inputs


def unit_scale(problem: RiccatiProblem) -> tuple[RiccatiProblem, float, float]:
    """The same problem with Q, R and BR⁻¹Bᵀ of comparable size, and the factors of S and K that lead back.

    The cost is divided by c and the input by b, powers of two near c = √(‖Q‖‖R‖)/‖B‖ and b² = c/‖R‖: no rounding, and
    a common factor of Q and R falls out of the gain.
    """
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    q, r, b = (float(np.linalg.norm(M, 2)) for M in (Q, R, B))
    half_r = 2 * round(np.log2(r) / 2)  # an even power, so that its root is exact too
    ratio = np.log2(q) - half_r if q > 0 else 0.0
    log_b = int(np.clip(round(ratio / 4 - (np.log2(b) if b > 0 else 0.0) / 2), -250, 250))
    input_scale, cost = 2.0**log_b, 2.0 ** (half_r + 2 * log_b)
    # û = u / input_scale turns B into input_scale·B, uᵀRu/cost into ûᵀ(R·input_scale²/cost)û
    scaled = RiccatiProblem(A, B * input_scale, Q / cost, R / 2.0**half_r, N * (input_scale / cost))
    return scaled, cost, input_scale
