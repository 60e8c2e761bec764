"""The observer's side of duality, worked out without ever transposing the plant: what the twin must agree with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import expm, schur

from app.engine import EngineError

NODES, WEIGHTS = np.polynomial.legendre.leggauss(48)


def observer_by_polynomial(A: np.ndarray, C: np.ndarray, poles: Sequence[complex]) -> np.ndarray:
    """L (n×1) = φ(A) O⁻¹ (0 … 0 1)ᵀ with φ the polynomial of the poles asked: Ackermann's formula for one output.

    A n×n, C 1×n. Raises EngineError where O = [C; CA; …] is singular.
    """
    rows = [C]
    for _ in range(len(A) - 1):
        rows.append(rows[-1] @ A)
    try:
        last = np.linalg.solve(np.vstack(rows), np.eye(len(A))[:, -1:])
    except np.linalg.LinAlgError:
        raise EngineError("This sensor does not see every state, so the formula for L fails; turn the sensor.") from None
    phi = np.zeros_like(A)
    for coefficient in np.real(np.poly(np.asarray(poles))):
        phi = phi @ A + coefficient * np.eye(len(A))
    return phi @ last


def filter_riccati(A: np.ndarray, C: np.ndarray, W: np.ndarray, V: np.ndarray) -> np.ndarray:
    """P (n×n) of AP + PAᵀ − PCᵀV⁻¹CP + W = 0 from the filter's own Hamiltonian [−Aᵀ CᵀV⁻¹C; W A].

    The Hamiltonian's unstable invariant subspace is spanned by [I; P]. A n×n, C p×n, W n×n ⪰ 0, V p×p > 0.
    Source: Laub, "A Schur method for solving algebraic Riccati equations" (1979), written for the filter.
    """
    n = len(A)
    hamiltonian = np.block([[-A.T, C.T @ np.linalg.solve(V, C)], [W, A]])
    basis = schur(hamiltonian, output="real", sort="rhp")[1][:, :n]
    P = np.linalg.solve(basis[:n].T, basis[n:].T).T
    return (P + P.T) / 2


def output_energy(A: np.ndarray, C: np.ndarray, horizon: float) -> np.ndarray:
    """E (n×n): E_ij = ∫₀ᵀ y_i(t)·y_j(t) dt, y_i the output after a start at the i-th unit state. Gauss quadrature.

    x(0)ᵀ E x(0) is the energy that the start x(0) leaves in the measurement within T seconds.
    """
    t = (NODES + 1) * horizon / 2
    y = C @ expm(t[:, None, None] * A)  # (48, p, n)
    return np.einsum("k,kpi,kpj->ij", WEIGHTS * horizon / 2, y, y)
