"""Compute transmission and invariant zeros of a plant."""

from __future__ import annotations

import numpy as np

from .balance import balance
from .gates.argument_checks import matrix, optional, takes
from .gates.plant_gate import PLANT
from .plant import Plant

__all__ = ["invariant_zeros", "transmission_zeros"]

RANK_RTOL = 1e-10  # of a block beside the largest of the balanced system: what is smaller is zero


@takes(plant=PLANT)
def transmission_zeros(plant: Plant) -> np.ndarray | None:
    """Zeros of a plant with as many inputs as outputs, sorted by (real, imag); None for other plants.

    The s where [A − sI, B; C, D] loses rank, in balanced states, inputs, outputs and time: states that y = 0 forbids
    are taken out by orthogonal steps, then those that no u = 0 leaves, until D is invertible; what remains are
    eig(A − B D⁻¹ C), as many as there are, none invented by rounding at infinity. A plant that loses rank at every s
    has none. Source: Emami-Naeini and Van Dooren, "Computation of zeros of linear multivariable systems" (1982).
    """
    if plant.m != plant.p:
        return None
    return invariant_zeros(plant.A, plant.B, plant.C, np.asarray(plant.D))


@takes(A=matrix("n n"), B=matrix("n m"), C=matrix("p n"), D=optional(matrix("p m")))
def invariant_zeros(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray | None = None) -> np.ndarray:
    """The s where [A − sI, B; C, D] loses rank, sorted by (real, imag), for A n×n, B n×m, C p×n, D p×m with p ≥ m.

    None where the rank is below n + m at every s. Method as in `transmission_zeros`.
    """
    D = np.zeros((len(C), B.shape[1])) if D is None else D
    own = balance(A, B, C, D)
    A, B, C, D = own.A(A) / own.rate, own.B(B) / own.rate, own.C(C), own.D(D)
    A, B, C, D = _without_forbidden(A, B, _even_rows(C, D), _even_rows(D, C))
    if D.shape[0] < D.shape[1]:
        return np.empty(0, dtype=complex)
    A, B, C, D = _turned(*_without_forbidden(*_turned(A, B, C, D)))
    found = np.linalg.eigvals(A - B @ np.linalg.solve(D, C)) if len(D) else np.linalg.eigvals(A)
    return np.sort_complex(own.rate * found.astype(complex))


def _even_rows(M: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """M with its rows divided by the length of those of [M, beside]: the unit of an output decides nothing."""
    size = np.hypot(np.linalg.norm(M, axis=1), np.linalg.norm(beside, axis=1))[:, None]
    return M / np.where(size > 0, size, 1.0)


def _turned(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray) -> tuple[np.ndarray, ...]:
    return A.T, C.T, B.T, D.T


def _without_forbidden(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray) -> tuple[np.ndarray, ...]:
    """The system on the states that can stay while y = 0, with as many outputs as D has rank: D of full row rank.

    Outputs that D does not reach forbid the states they see; that those stay zero is the next output.
    """
    while True:
        floor = RANK_RTOL * max(1.0, *(float(np.linalg.norm(M)) for M in (A, B) if M.size), 0.0)
        U, s, _ = np.linalg.svd(D)
        rank = int(np.count_nonzero(s > floor))
        C, D = U.T @ C, U.T @ D
        rest = C[rank:]
        if not rest.size:
            return A, B, C[:rank], D[:rank]
        _, seen, Vt = np.linalg.svd(rest)
        forbidden = int(np.count_nonzero(seen > floor))
        if not forbidden:
            return A, B, C[:rank], D[:rank]
        keep, drop = Vt[forbidden:].T, Vt[:forbidden].T
        C = np.vstack([C[:rank] @ keep, drop.T @ A @ keep])
        D = np.vstack([D[:rank], drop.T @ B])
        A, B = keep.T @ A @ keep, keep.T @ B
