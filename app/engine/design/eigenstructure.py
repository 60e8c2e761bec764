"""Compute admissible eigenvectors and place poles one by one by deflation."""

from __future__ import annotations

import numpy as np

from ..systems.pole_sets import Poles

__all__ = ["controllable_split", "eigenvector_spaces", "input_factors", "place_by_deflation"]

RANK_TOLERANCE = 1e-12


def controllable_split(A: np.ndarray, B: np.ndarray, rtol: float = RANK_TOLERANCE) -> tuple[np.ndarray, int]:
    """Orthogonal Q (x = Q z) and the number of leading coordinates of z that the input reaches (staircase form).

    In z: A = [[A1, A12], [0, A2]], B = [[B1], [0]] with (A1, B1) controllable. Ranks are decided by singular values
    above rtol·‖B‖ in the first step and rtol·‖A‖ in the later ones.
    """
    n = A.shape[0]
    work, Q, block = A.copy(), np.eye(n), B
    floor = rtol * np.linalg.norm(B)
    reached = 0
    while reached < n:
        U, s, _ = np.linalg.svd(block)
        rank = int(np.count_nonzero(s > floor))
        if rank == 0:
            break
        work[reached:] = U.T @ work[reached:]
        work[:, reached:] = work[:, reached:] @ U
        Q[:, reached:] = Q[:, reached:] @ U
        block = work[reached + rank :, reached : reached + rank]
        reached += rank
        floor = rtol * np.linalg.norm(A)
    return Q, reached


def input_factors(B: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """U0 (n×r, orthonormal range of B), U1 (its complement) and the pseudo-inverse B⁺ (m×n)."""
    U, s, Vt = np.linalg.svd(B)
    r = int(np.count_nonzero(s > RANK_TOLERANCE * s[0])) if s.size else 0
    return U[:, :r], U[:, r:], (Vt[:r].T / s[:r]) @ U[:, :r].T


def eigenvector_spaces(A: np.ndarray, U1: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """For each λ an orthonormal basis (n×r) of the null space of U1ᵀ(A − λI): the x with (A − λI)x in range(B)."""
    k = U1.shape[1]
    stack = (U1.T @ A)[None] - poles[:, None, None] * U1.T[None]
    Q = np.linalg.qr(np.conj(np.swapaxes(stack, 1, 2)), mode="complete")[0]
    return Q[:, :, k:]


def place_by_deflation(A: np.ndarray, B: np.ndarray, poles: Poles) -> np.ndarray:
    """Gain K (m×n) that makes A − BK quasi-triangular in an orthonormal basis, one pole or pair after the other.

    With (A − λI)x = B f and Q = [q, Q₂] orthogonal, q along x: K = f (qᵀx)⁻¹ qᵀ + K₂ Q₂ᵀ, where K₂ places the other
    poles of (Q₂ᵀAQ₂, Q₂ᵀB). Works for any multiplicity (the closed loop is then defective) and for one input.
    Method: orthogonal deflation after Miminis and Paige (1982) and Varga (1981).
    """
    K, frame = np.zeros((B.shape[1], A.shape[0])), np.eye(A.shape[0])
    for pole in poles[poles.imag >= 0]:
        width = 2 if pole.imag > 0 else 1
        basis, f = _cheapest_vector(A, B, pole if width == 2 else pole.real)
        Q, R = np.linalg.qr(basis, mode="complete")
        K += np.linalg.solve(R[:width].T, f.T).T @ (frame @ Q[:, :width]).T
        rest = Q[:, width:]
        A, B, frame = rest.T @ A @ rest, rest.T @ B, frame @ rest
    return K


def _cheapest_vector(A: np.ndarray, B: np.ndarray, pole: complex | float) -> tuple[np.ndarray, np.ndarray]:
    """Real basis (n×1 or n×2) of an admissible eigenvector and its input directions f, the smallest there are."""
    _, U1, B_inverse = input_factors(B)
    S = eigenvector_spaces(A, U1, np.array([pole]))[0]
    image = B_inverse @ (A @ S - pole * S)
    turns = np.linalg.svd(image)[2].conj().T[:, ::-1]
    if not np.iscomplexobj(S):
        return S @ turns[:, :1], image @ turns[:, :1]
    choices = [turns[:, i] for i in range(turns.shape[1])]
    choices += [turns[:, i] + 1j * turns[:, k] for i in range(turns.shape[1]) for k in range(i)]
    best, basis, directions = -1.0, np.zeros((len(A), 0)), choices[0]
    for c in choices:
        x = S @ c
        pair = np.column_stack([x.real, x.imag]) / np.linalg.norm(x)
        spread = np.linalg.svd(pair, compute_uv=False)[-1]
        if not basis.size or spread > best:
            best, basis, directions = float(spread), pair, image @ c / np.linalg.norm(x)
        if best > 0.1:
            break
    return basis, np.column_stack([np.real(directions), np.imag(directions)])
