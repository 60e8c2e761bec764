"""Solve Sylvester equations, continuous and sampled."""

from __future__ import annotations

import numpy as np
from scipy.linalg import schur, solve_sylvester, solve_triangular

from ..systems.errors import EngineError

__all__ = ["sampled_sylvester", "sylvester"]

APART = 1e-14  # relative distance from a pole of the other matrix below which no solution is unique


def sylvester(A: np.ndarray, Q: np.ndarray, C: np.ndarray) -> np.ndarray:
    """X (n×k) of AX + XQ + C = 0, by Bartels and Stewart."""
    first, second = np.linalg.eigvals(A), np.linalg.eigvals(Q)
    sums, size = np.abs(first[:, None] + second), max(np.abs(first).max(initial=0.0), np.abs(second).max(initial=0.0))
    if sums.min(initial=np.inf) <= APART * size:
        raise EngineError("The Sylvester equation has no unique solution: a pole of A is minus one of Q.")
    return np.asarray(solve_sylvester(A, Q, -C)) if C.size else np.zeros(C.shape)


def sampled_sylvester(A: np.ndarray, Q: np.ndarray, C: np.ndarray) -> np.ndarray:
    """X (n×k) of AXQ − X + C = 0: with Schur forms A = U S Uᴴ, Q = V T Vᴴ one column of UᴴXV after the other."""
    first, second = np.linalg.eigvals(A), np.linalg.eigvals(Q)
    if np.abs(first[:, None] * second - 1).min(initial=np.inf) <= APART:
        raise EngineError("The Sylvester equation has no unique solution: a pole of A is the inverse of one of Q.")
    if not C.size:
        return np.zeros(C.shape)
    (S, U), (T, V) = schur(A, output="complex"), schur(Q, output="complex")
    right, Y = U.conj().T @ C @ V, np.zeros(C.shape, dtype=complex)
    for k in range(C.shape[1]):
        Y[:, k] = solve_triangular(np.eye(len(S)) - T[k, k] * S, right[:, k] + S @ (Y[:, :k] @ T[:k, k]))
    return np.real(U @ Y @ V.conj().T)
