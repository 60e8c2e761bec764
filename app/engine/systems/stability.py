"""Decide which poles of a matrix are stable: the one judgement that all of the engine uses.

A matrix is judged as the doubles that it holds, each uncertain by rounding and its zeros exact. So a block triangular matrix is
judged block by block, and a fast block takes no digits from a slow one.
"""

from __future__ import annotations

import warnings
from contextlib import suppress

import numpy as np
from scipy.linalg import eig, solve_continuous_lyapunov, solve_discrete_lyapunov
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from .arrays import symmetric
from .balance import plain_scale, state_scale
from .exact_roots import MAX_STATES, exact_poles
from .gates.argument_checks import PERIOD, POLES, matrix, takes

__all__ = ["all_stable", "is_stable", "poles_within", "stable_poles"]

CLEARLY = 10.0  # times rounding
EPS = float(np.finfo(float).eps)


@takes(poles=POLES, dt=PERIOD)
def all_stable(poles: np.ndarray, *, dt: float = 0.0) -> bool:
    """Whether every number of a set is stable as it stands: Re s < 0, or |s| < 1 where dt > 0. For a matrix ask `is_stable`."""
    return bool(_inside(poles, dt).all())


@takes(A=matrix("n n"), dt=PERIOD)
def is_stable(A: np.ndarray, *, dt: float = 0.0) -> bool:
    """Whether every eigenvalue of A (n×n) is stable by more than rounding can move it; see `stable_poles`."""
    clear = _clear(A, dt)
    if clear is not None:
        return clear
    if len(A) > MAX_STATES and _stays_stable(A * (plain := plain_scale(A)) / plain[:, None], dt):
        return True
    return all(bool(stable.all()) for _, stable in _judged(A, dt))


@takes(A=matrix("n n"), dt=PERIOD)
def stable_poles(A: np.ndarray, *, dt: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """eig(A) (n,) and which of them are stable by more than rounding can move them: Re s < 0, |z| < 1 where dt > 0.

    Each irreducible diagonal block of A is judged by itself. What double precision leaves in doubt is decided by the exact
    eigenvalues of a block of at most thirty states, each entry of which may change by rounding.
    """
    judged = _judged(A, dt)
    if not judged:
        return np.empty(0, dtype=complex), np.empty(0, dtype=bool)
    return np.concatenate([poles for poles, _ in judged]), np.concatenate([stable for _, stable in judged])


def poles_within(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """eig(A) (n,), and by how much rounding can have moved each, one irreducible diagonal block after the other.

    Rounding n·eps·‖A‖ in balanced states moves a simple pole by that over |wᴴv|, w and v its unit eigenvectors, and
    any pole by no more than the n-th root lets it. Source: Elsner, "An optimal bound for the spectral variation of
    two matrices" (1985).
    """
    found = [_within(*_balanced(block))[:2] for block in irreducible_blocks(A)]
    if not found:
        return np.empty(0, dtype=complex), np.empty(0)
    return np.concatenate([poles for poles, _ in found]), np.concatenate([slack for _, slack in found])


def irreducible_blocks(A: np.ndarray) -> list[np.ndarray]:
    """The diagonal blocks of A whose states act on each other both ways; together they have the eigenvalues of A."""
    if len(A) < 2 or np.all(A != 0):
        return [A] if len(A) else []
    count, label = connected_components(csr_array(A != 0), directed=True, connection="strong")
    if count == 1:
        return [A]
    members = [np.flatnonzero(label == k) for k in range(count)]
    return [A[np.ix_(rows, rows)] for rows in members]


def _inside(poles: np.ndarray, dt: float) -> np.ndarray:
    return np.abs(poles) < 1 if dt > 0 else np.real(poles) < 0


def _depth(poles: np.ndarray, dt: float) -> np.ndarray:
    """How far each pole lies inside the region of stability."""
    return 1 - np.abs(poles) if dt > 0 else -np.real(poles)


def _clear(A: np.ndarray, dt: float) -> bool | None:
    """Whether A is stable, where every pole is ten times farther from the edge than rounding can move it, None elsewhere.

    Rounding n·eps·‖A‖ moves a pole by at most that times the condition of the eigenvectors. Source: Bauer and Fike, "Norms and
    exclusion theorems" (1960). A first look: most matrices need no other.
    """
    if not len(A):
        return True
    poles, vectors = np.linalg.eig(A)
    depth, dust = _depth(poles, dt), CLEARLY * len(A) * EPS * float(np.linalg.norm(A))
    # an inverse bounds the condition from both sides in a fifth of the time of singular values
    with suppress(np.linalg.LinAlgError), np.errstate(over="ignore", invalid="ignore"):
        most = dust * float(np.linalg.norm(vectors) * np.linalg.norm(np.linalg.inv(vectors)))
        if np.all(np.abs(depth) > most):
            return bool(np.all(depth > 0))
        if np.any(np.abs(depth) <= most / (2 * len(A))):
            return None
    singular = np.linalg.svd(vectors, compute_uv=False)
    slack, depth = dust * singular[0], depth * singular[-1]
    return bool(np.all(depth > slack)) if np.all(np.abs(depth) > slack) else None


def _judged(A: np.ndarray, dt: float) -> list[tuple[np.ndarray, np.ndarray]]:
    return [_judge(block, dt) for block in irreducible_blocks(A)]


def _judge(A: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Poles of an irreducible block and which of them are stable."""
    if len(A) == 1:
        poles = A[0].astype(complex)
        return poles, _depth(poles, dt) > EPS * np.abs(A[0])
    balanced, scale = _balanced(A)
    plain = plain_scale(A)
    poles, slack, own = _within(balanced, scale)
    stable = _depth(poles, dt) > slack
    if not np.any(np.abs(_depth(poles, dt)) <= slack):
        return poles, stable
    if len(A) > MAX_STATES and any(_stays_stable(M, dt) for M in (balanced, A * plain / plain[:, None])):
        return poles, np.ones(len(poles), dtype=bool)
    if len(A) <= MAX_STATES:
        none = np.zeros((len(A), 0)), np.zeros((0, len(A)))
        poles = exact_poles(A, *none, poles, scale).values
    stable = _depth(poles, dt) > own
    inside = _inside(poles, dt)
    return poles, inside if len(A) <= MAX_STATES and np.any(inside & ~stable) and _none_can_cross(balanced, poles, dt) else stable


def _balanced(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    scale = state_scale(A)
    return A * scale / scale[:, None], scale


def _within(balanced: np.ndarray, scale: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poles; what rounding in finding them can have moved each by; and what rounding of each entry of A can."""
    n = len(balanced)
    if n == 1:
        slack = EPS * np.abs(balanced[0])
        return balanced[0].astype(complex), slack, slack
    poles, left, right = tuple(eig(balanced, left=True, right=True))
    size = float(np.linalg.norm(balanced, 2))
    dust = n * EPS * size
    cosine = np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), 1e-300)
    most = (2 * size) ** (1 - 1 / n) * dust ** (1 / n)
    entries = n * EPS * np.sum(np.abs(left) * (np.abs(balanced) @ np.abs(right)), axis=0) / cosine
    return poles, np.minimum(dust / cosine, most), np.minimum(entries, most)


def _stays_stable(A: np.ndarray, dt: float) -> bool:
    """Whether AᵀX + XA = −I, or AᵀXA − X = −I, has a solution X > 0 that also proves every matrix stable that differs from A by ten
    times rounding: 2 ‖X‖ ‖E‖ (or 2 ‖A‖ ‖X‖ ‖E‖ + ‖X‖ ‖E‖²) and what the equation misses stay below 1."""
    one = np.eye(len(A))
    with np.errstate(over="ignore", invalid="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            X = symmetric(solve_discrete_lyapunov(A.T, one, "bilinear") if dt > 0 else solve_continuous_lyapunov(A.T, -one))
            np.linalg.cholesky(X)
        except (np.linalg.LinAlgError, ValueError):
            return False
    XA = X @ A
    rest = A.T @ XA - X + one if dt > 0 else XA + XA.T + one

    def proves(order: int | None) -> bool:
        size, missed, largest = (float(np.linalg.norm(M, order)) for M in (A, rest, X))
        moved = CLEARLY * len(A) * EPS * size
        return missed + largest * moved * (2 * size + moved if dt > 0 else 2) < 1
    return proves(None) or proves(2)  # the norm of Frobenius is the larger, and takes no singular values


def _none_can_cross(balanced: np.ndarray, poles: np.ndarray, dt: float) -> bool:
    """Whether no change of A as large as rounding takes a pole over the edge of stability, copies of a multiple one
    included: σ_min(A − s I) on the edge, beside the poles and in between, stays above it. Source: Van Loan, "How near is a
    stable matrix to an unstable matrix?" (1985)."""
    places = np.unique(np.abs(np.angle(poles) if dt > 0 else np.imag(poles)))
    places = np.concatenate([[0.0], places, (places[1:] + places[:-1]) / 2, [np.pi] if dt > 0 else []])
    edge = np.exp(1j * places) if dt > 0 else 1j * places
    least = np.linalg.svd(edge[:, None, None] * np.eye(len(balanced)) - balanced, compute_uv=False)[:, -1]
    return bool(least.min() > CLEARLY * len(balanced) * EPS * np.linalg.norm(balanced, 2))
