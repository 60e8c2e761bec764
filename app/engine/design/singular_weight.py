"""Discrete Riccati equations where R is singular: inputs without a cost, sensors without noise."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_discrete_are

from ..systems.arrays import correlations, symmetric
from .riccati import discrete_residual, summed
from .riccati_problem import RiccatiProblem, in_balanced_units, unit_scale

__all__ = ["solve_singular"]

STEPS = 4  # of Newton's method, as long as they help
LEAST = 1e-13  # least eigenvalue of the correlations of R + BᵀSB


def solve_singular(problem: RiccatiProblem) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Stabilising S, K and the relative residual where R ≥ 0 is singular but R + BᵀSB is not.

    SciPy's extended pencil needs no inverse of R. None where there is no such S.
    """
    plain, first_cost, first_input = unit_scale(problem)
    own, x, u = in_balanced_units(plain)
    scaled, cost, push = unit_scale(own)
    cost, push = first_cost * cost, first_input * push
    try:
        S = symmetric(solve_discrete_are(scaled.A, scaled.B, scaled.Q, scaled.R, s=scaled.N if scaled.N.any() else None))
        S, K, size = _polished(scaled, S)
    except (np.linalg.LinAlgError, ValueError):
        return None
    weight = symmetric(scaled.R + scaled.B.T @ S @ scaled.B)
    if not np.diag(weight).min() > 0 or np.linalg.eigvalsh(correlations(weight)[0])[0] < LEAST:
        return None
    return cost * S / x / x[:, None], push * K * u[:, None] / x, size


def _polished(problem: RiccatiProblem, S: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    residual, size, K = discrete_residual(problem, S)
    for _ in range(STEPS):
        better = symmetric(S + summed(problem.A - problem.B @ K, residual))
        residual, smaller, K_ = discrete_residual(problem, better)
        if not smaller < size:
            break
        S, size, K = better, smaller, K_
    return S, K, size
