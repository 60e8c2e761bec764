"""Decompose a plant: staircase form and Kalman decomposition.

rank(O) is not asked: it falls to 7 on a plant of twenty visible modes. The staircase only ever compares
one block with ‖A‖, and changes coordinates by orthogonal matrices.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from scipy.linalg.lapack import dgeqrf, dgesdd, dormqr  # pyright: ignore[reportAttributeAccessIssue]

from ..systems.arrays import frozen
from ..systems.balance import balance, natural_scale, state_scale
from ..systems.errors import EngineError
from ..systems.gates.argument_checks import matrix, number, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record

__all__ = ["KalmanDecomposition", "kalman_decomposition", "reachable_subspace", "unobservable_subspace"]

DEFAULT_RTOL = 1e-10
FEW_STATES = 30  # beyond it the powers of A hide what is reached
EPS = float(np.finfo(float).eps)


def tolerance(rtol: float | None) -> float:
    """The relative tolerance asked for, or the default; EngineError unless 0 ≤ rtol < 1."""
    value = DEFAULT_RTOL if rtol is None else float(rtol)
    if not 0 <= value < 1:
        raise EngineError("rtol must be at least 0 and below 1; it is {value:g}.", value=value)
    return value


def _unit_columns(B: np.ndarray) -> np.ndarray:
    """B with its non-zero columns scaled to length one: the unit of an input or output decides nothing."""
    size = np.sqrt((B * B).sum(axis=0))
    return B / np.where(size > 0, size, 1.0)


def _size(A: np.ndarray) -> float:
    return float(np.linalg.norm(A, 2)) if A.size else 0.0


def _staircase(A: np.ndarray, B: np.ndarray, rtol: float, size: float) -> tuple[np.ndarray, int]:
    """Orthogonal Q and r: the first r columns of Q span the subspace that B reaches through A.

    Zero means below rtol for B (its columns have length one), below rtol·size for a block of A. A step turns a block to a triangle
    by Householder's reflections, which reach the whole of A in n² operations a column, and takes the singular values of that.
    """
    n = A.shape[0]
    Q, A, done = np.eye(n, order="F"), np.array(A, order="F"), 0
    block, bound = B, rtol
    while done < n and block.size:
        reflections, tau = dgeqrf(block)[:2]
        U, s, _ = np.linalg.svd(np.triu(reflections[:len(tau)]))
        step = int(np.count_nonzero(s > bound))
        if step == 0:
            break
        reflections, top = reflections[:, :len(tau)], slice(done, done + len(tau))
        A[done:] = _reflected("L", "T", reflections, tau, A[done:])
        A[top] = U.T @ A[top]
        for M in (A, Q):
            M[:, done:] = _reflected("R", "N", reflections, tau, M[:, done:])
            M[:, top] = M[:, top] @ U
        block, bound = A[done + step:, done:done + step], rtol * size
        done += step
    return Q, done


def _reflected(side: str, turned: str, reflections: np.ndarray, tau: np.ndarray, M: np.ndarray) -> np.ndarray:
    return dormqr(side, turned, reflections, tau, M, 64 * max(M.shape))[0]


def balanced_staircase(A: np.ndarray, B: np.ndarray, rtol: float | None = None) -> tuple[np.ndarray, np.ndarray, int]:
    """The scales d (n,) of the states x = d ∘ x_b, and in x_b an orthogonal Q whose first r columns span what B reaches."""
    scale = state_scale(A, B)
    balanced = A * scale / scale[:, None]
    return scale, *_staircase(balanced, _unit_columns(B / scale[:, None]), tolerance(rtol), _size(balanced))


def clearly_reached(A: np.ndarray, B: np.ndarray, rtol: float | None = None) -> bool:
    """Whether Kalman's rank test alone shows that B reaches every state: a first look, for few states.

    In balanced states with ‖A‖ = 1, rank [B, AB, …, Aⁿ⁻¹B] = n for all pairs that differ from (A, B) by what the staircase takes for
    zero, √n·rtol. Such a change moves the matrix, and so its least singular value, by at most n²·√m·rtol.
    """
    n, zero = len(A), max(tolerance(rtol), len(A) * EPS)
    if not 0 < n <= FEW_STATES or not B.size:
        return n == 0
    scale = state_scale(A, B)
    balanced = A * scale / scale[:, None]
    F, m = balanced / (dgesdd(balanced, compute_uv=0)[1][0] or 1.0), B.shape[1]
    powers = np.empty((n, n * m), order="F")
    powers[:, :m] = _unit_columns(B / scale[:, None])
    for k in range(m, n * m, m):
        powers[:, k:k + m] = F.dot(powers[:, k - m:k])
    _, values, _, failure = dgesdd(powers, compute_uv=0)
    return not failure and bool(values[-1] > n**2 * math.sqrt(m) * zero)


@takes(A=matrix("n n"), B=matrix("n m"), rtol=number())
def reachable_subspace(A: np.ndarray, B: np.ndarray, *, rtol: float | None = None) -> tuple[np.ndarray, int]:
    """The states that an input can reach: im [B, AB, …, Aⁿ⁻¹B].

    A n×n, B n×m. Returns an orthogonal T (n×n) and r: the first r columns of T span the reachable
    subspace, so TᵀAT = [A₁ A₁₂; 0 A₂] and TᵀB = [B₁; 0]. A block of the staircase counts as zero below
    rtol·‖A‖ (rtol·‖B‖ in the first step), measured in balanced state units with inputs of unit size.
    Source: van Dooren, "The generalized eigenstructure problem in linear system theory" (1981), staircase form.
    """
    scale, Q, r = balanced_staircase(A, B, rtol)
    plain = natural_scale(A, B)
    if np.any(plain != scale):  # a basis in the states given, where it is as wide
        like = A * plain / plain[:, None]
        turned, count = _staircase(like, _unit_columns(B / plain[:, None]), tolerance(rtol), _size(like))
        if count == r:
            scale, Q = plain, turned
    if np.all(scale == 1):
        return Q, r
    return np.linalg.qr(np.hstack([scale[:, None] * Q[:, :r], Q[:, r:] / scale[:, None]]))[0], r


@takes(A=matrix("n n"), C=matrix("p n"), rtol=number())
def unobservable_subspace(A: np.ndarray, C: np.ndarray, *, rtol: float | None = None) -> tuple[np.ndarray, int]:
    """The states that leave no trace in y: ker [C; CA; …; CAⁿ⁻¹], by duality.

    A n×n, C p×n. Returns an orthogonal T (n×n) and h: the last h columns of T span the hidden subspace, so
    TᵀAT = [A₁ 0; A₂₁ A₂] and CT = [C₁ 0].
    """
    Q, seen = reachable_subspace(A.T, C.T, rtol=rtol)
    return Q, A.shape[0] - seen


def in_new_states(plant: Plant, A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray | None,
                  label: str) -> Plant:
    """A plant with the same inputs, outputs and period, whose states have lost their names and units."""
    signals = (*plant.input_names, *plant.output_names)
    units = tuple((name, unit) for name, unit in plant.units if name in signals)
    name = f"{plant.name} {label}".strip()
    through = np.zeros((len(C), B.shape[1])) if D is None else D
    return Plant(A, B, C, through, plant.dt, (), plant.input_names, plant.output_names, units, name)


@record()
class KalmanDecomposition:
    """x = T z with z ordered (reached and seen, reached only, seen only, neither).

    A = T⁻¹AT = [A₁ 0 A₁₃ 0; A₂₁ A₂ A₂₃ A₂₄; 0 0 A₃ 0; 0 0 A₄₃ A₄], B = [B₁; B₂; 0; 0], C = [C₁ 0 C₃ 0];
    the zeros are exact. `sizes` = (co, c_not_o, not_c_o, not_c_not_o); `parts` are the four diagonal plants
    in that order (None where empty; D belongs to the first); `minimal` is the first, with C₁(sI−A₁)⁻¹B₁ + D
    equal to the plant's transfer function (it has no states when nothing is both reached and seen).
    """

    T: np.ndarray
    sizes: tuple[int, int, int, int]
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    parts: tuple[Plant | None, Plant | None, Plant | None, Plant | None]
    minimal: Plant


_ZERO_A = np.array([[0, 1, 0, 1], [0, 0, 0, 0], [1, 1, 0, 1], [1, 1, 0, 0]], dtype=bool)


def _subspaces(plant: Plant, rtol: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bases of R ∩ N, of its complement in R (reachable) and of its complement in N (hidden).

    R ∩ N is found inside R, as the part of R that C does not see: no angle between subspaces is ever judged.
    """
    scale = balance(plant.A, plant.B, plant.C).states
    A = plant.A * scale / scale[:, None]
    B, C = _unit_columns(plant.B / scale[:, None]), _unit_columns((plant.C * scale).T).T
    size = _size(A)
    Q, r = _staircase(A, B, rtol, size)
    R = Q[:, :r]
    Q, seen = _staircase((R.T @ A @ R).T, (C @ R).T, rtol, size)
    both, reached = R @ Q[:, seen:], R @ Q[:, :seen]
    Q, seen = _staircase(A.T, C.T, rtol, size)
    N = Q[:, seen:]
    neither = min(max(N.shape[1] - both.shape[1], 0), plant.n - r)
    _, sines, V = np.linalg.svd(N - R @ (R.T @ N), full_matrices=True)
    if neither and sines[neither - 1] < 1e-9:
        raise EngineError("Reachable and hidden states nearly coincide here; choose a larger rtol to tell them "
                          "apart.")
    return scale[:, None] * both, scale[:, None] * reached, scale[:, None] * (N @ V[:neither].T)


def _basis(plant: Plant, rtol: float) -> tuple[np.ndarray, tuple[int, int, int, int]]:
    """T and the block sizes; each block orthonormal, R and N orthonormal, the rest orthogonal to both."""
    both, reached, hidden = _subspaces(plant, rtol)
    k = both.shape[1]
    R = np.linalg.qr(np.hstack([both, reached]))[0]
    N = np.linalg.qr(np.hstack([both, hidden]))[0]
    spanned = np.hstack([R, N[:, k:]])
    rest = (np.linalg.svd(spanned)[0] if spanned.size else np.eye(plant.n))[:, spanned.shape[1]:]
    T = np.hstack([R[:, k:], R[:, :k], rest, N[:, k:]])
    return T, (R.shape[1] - k, k, rest.shape[1], N.shape[1] - k)


@takes(plant=PLANT, rtol=number())
def kalman_decomposition(plant: Plant, *, rtol: float | None = None) -> KalmanDecomposition:
    """Split the state into what is reached and seen, reached only, seen only, and neither.

    x = T z, ż = T⁻¹AT z + T⁻¹B u, y = CT z + D u; shapes as the plant's. T has unit columns, orthonormal
    within each block, and orthogonal throughout unless hidden and reachable subspaces meet obliquely.
    Raises EngineError for rtol outside [0, 1), or where the two subspaces cannot be told apart at rtol.
    Source: Kalman, "Mathematical description of linear dynamical systems" (1963), theorem 5.

    >>> kalman_decomposition(Plant(np.diag([-1, -2]), [[1], [1]], [[1, 0]])).sizes
    (1, 1, 0, 0)
    """
    T, sizes = _basis(plant, tolerance(rtol))
    if sizes[0] == plant.n:  # nothing to take apart
        T = np.eye(plant.n)
    A, B, C = np.linalg.solve(T, plant.A @ T), np.linalg.solve(T, plant.B), plant.C @ T
    edges = np.cumsum((0, *sizes))
    cuts = [slice(a, b) for a, b in pairwise(edges)]
    for i, rows in enumerate(cuts):
        for j, columns in enumerate(cuts):
            if _ZERO_A[i, j]:
                A[rows, columns] = 0.0
    B[cuts[2].start:] = 0.0
    C[:, cuts[1]] = C[:, cuts[3]] = 0.0
    T, A, B, C = (frozen(matrix) for matrix in (T, A, B, C))

    def part(i: int, label: str) -> Plant:
        D = plant.D if i == 0 else None
        return in_new_states(plant, A[cuts[i], cuts[i]], B[cuts[i]], C[:, cuts[i]], D, label)

    labels = ("reached and seen", "reached, hidden", "seen, not reached", "neither reached nor seen")
    plants = tuple(part(i, label) if sizes[i] else None for i, label in enumerate(labels))
    return KalmanDecomposition(T, sizes, A, B, C, plants, part(0, labels[0]))  # type: ignore[arg-type]
