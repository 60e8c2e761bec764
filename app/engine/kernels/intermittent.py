"""Step the covariance of a filter with intermittent measurements."""

from __future__ import annotations

import numpy as np

from .filter_bank import gained, joseph_form
from .small_matrices import product, put, symmetrise, turn

__all__ = ["lossy_covariance_steps"]


def lossy_covariance_steps(A, C, Q, R, P, heard, path):
    """Fill path (len(heard) + 1, n, n) from P on: P⁺ = A ((1 − h) P + h P|y) Aᵀ + Q with h = heard[k] and P|y in Joseph's form.

    The number of steps done: it ends where C P Cᵀ + R is not positive definite. P is symmetric, and used up.
    """
    n, p = len(A), len(C)
    AT, CT, across, S, L = np.empty((n, n)), np.empty((n, p)), np.empty((n, p)), np.empty((p, p)), np.empty((p, p))
    turned, M, after, X = np.empty((p, n)), np.empty((n, p)), np.empty((n, n)), np.empty((n, n))
    turn(A, AT)
    turn(C, CT)
    put(P, path[0])
    for k in range(len(heard)):
        product(P, CT, False, across)
        product(C, across, False, S)
        symmetrise(S, R, S)
        if not S[0, 0] > 0.0 or not gained(S, across, L, turned, M):
            return k
        joseph_form(P, C, R, M, after)
        for i in range(n):
            for j in range(n):
                after[i, j] = P[i, j] + heard[k] * (after[i, j] - P[i, j])
        product(A, after, False, X)
        product(X, AT, True, after)
        symmetrise(after, Q, P)
        put(P, path[k + 1])
    return len(heard)
