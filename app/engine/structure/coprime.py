"""Compute right coprime factors of (sI − Aᵀ)⁻¹ Cᵀ."""

from __future__ import annotations

import numpy as np

from ..systems.arrays import frozen
from ..systems.balance import state_scale
from ..systems.errors import EngineError
from ..systems.gates.argument_checks import takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record
from .analysis import observability

__all__ = ["CoprimeFactors", "coprime_factors"]

DEPENDENT = 1e-9  # a unit vector this near the span of earlier ones depends on them
SPAN_DISTANCE_SHARE = 0.1  # of one power of Aᵀ, a vector comes last that is this much nearer to the span than another


@record()
class CoprimeFactors:
    """(sI − Aᵀ)⁻¹ Cᵀ = H(s) L(s)⁻¹ with H(s) = Σ H[k] sᵏ (n×p) and L(s) = Σ L[k] sᵏ (p×p), right coprime.

    H is (d, n, p), L (d+1, p, p) with d the largest of the observability `indices` (p,), whose sum is n; column i of
    L is monic of degree indices[i] in row i.
    """

    H: np.ndarray
    L: np.ndarray
    indices: tuple[int, ...]

    def H_at(self, s: complex) -> np.ndarray:
        """H(s), n×p, real for real s."""
        return _horner(self.H, s)

    def L_at(self, s: complex) -> np.ndarray:
        """L(s), p×p, real for real s."""
        return _horner(self.L, s)

    def exact_at(self, A: np.ndarray, C: np.ndarray, s: complex) -> tuple[np.ndarray, np.ndarray]:
        """H(s), L(s), each column moved to the nearest solution of (sI − Aᵀ)h = Cᵀl, so that the rounding of the
        coefficients, which grows with the powers of s, is gone; relative to each entry, so zeros stay zeros."""
        columns = np.vstack([self.H_at(s), self.L_at(s)]).T
        system = np.hstack([s * np.eye(len(A)) - A.T, -C.T])
        moved = np.array([_nearest(system, column) for column in columns]).T
        return moved[:len(A)], moved[len(A):]


def _nearest(system: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The solution of system · v = 0 nearest to v, each entry in its own size."""
    size = np.where(v != 0, np.abs(v), np.abs(v).max() * 1e-16)
    return v - size * np.linalg.lstsq(system * size, system @ v, rcond=None)[0]


def _horner(coefficients: np.ndarray, s: complex) -> np.ndarray:
    value = coefficients[-1]
    for matrix in coefficients[-2::-1]:
        value = value * s + matrix
    return value


@takes(plant=PLANT)
def coprime_factors(plant: Plant) -> CoprimeFactors:
    """H(s), L(s) of (sI − Aᵀ)⁻¹Cᵀ = H(s) L(s)⁻¹ for an observable plant, column degrees as low as they go.

    In the chain c₁, …, c_p, Aᵀc₁, …, Aᵀc_p, (Aᵀ)²c₁, … the first (Aᵀ)^ν c_i that depends on those before gives
    column i of L: Σ_k (Aᵀ)ᵏ Cᵀ L_k = 0 (of one power, those that nearly depend come last); then
    H_k = Σ_{j>k} (Aᵀ)^{j−k−1} Cᵀ L_j. Computed in balanced states and in a unit of time where ‖A‖ = 1. Raises
    EngineError for a plant with hidden modes, or one so nearly so that the chain does not reach n.
    Source: Duan, Li, Zhou (1993), equation (10).
    """
    hidden = observability(plant).unobservable
    if hidden:
        raise EngineError("The plant has unobservable modes. Functional observers need an observable plant, so measure more or remove "
                          "those modes.")
    scale = state_scale(plant.A, None, plant.C)
    A, C = (plant.A * scale / scale[:, None]).T, (plant.C * scale).T
    speed = _power_of_two(np.array(np.linalg.norm(A, 2)))  # powers of two: nothing is rounded
    unit = _power_of_two(np.linalg.norm(C, axis=0))
    indices, L = _relations(A / speed, C / unit)
    d, p = max(indices), plant.p
    steps = np.arange(d + 1)
    # from s/speed back to s, from unit rows of C back to C; column i stays monic
    degrees = np.array(indices)
    L = L * speed ** (degrees[None, None, :] - steps[:, None, None]) * unit[None, None, :] / unit[None, :, None]
    H = np.zeros((d, plant.n, p))
    for k in range(d - 1, -1, -1):
        H[k] = C @ L[k + 1] + (A @ H[k + 1] if k + 1 < d else 0.0)
    return CoprimeFactors(frozen(H / scale[:, None]), frozen(L), indices)


def _power_of_two(size: np.ndarray) -> np.ndarray:
    return 2.0 ** np.round(np.log2(np.where(size > 0, size, 1.0)))


def _relations(A: np.ndarray, C: np.ndarray) -> tuple[tuple[int, ...], np.ndarray]:
    """Observability indices and the coefficients L (d+1, p, p) of the first dependence in each output's chain."""
    n, p = C.shape
    basis, frame = np.zeros((n, 0)), np.zeros((n, 0))
    kept: list[tuple[int, int]] = []
    found: dict[int, tuple[int, np.ndarray, int]] = {}
    tips, power = C.copy(), 0
    while len(found) < p:
        waiting = [i for i in range(p) if i not in found]
        while waiting:
            rests = [_beyond(frame, tips[:, i]) for i in waiting]
            shares = [np.linalg.norm(r) / max(float(np.linalg.norm(tips[:, i])), 1e-300) for r, i in zip(rests, waiting, strict=True)]
            at = next(k for k, share in enumerate(shares) if share >= SPAN_DISTANCE_SHARE * max(shares))
            i, rest = waiting.pop(at), rests[at]
            v = tips[:, i]
            if np.linalg.norm(rest) <= DEPENDENT * np.linalg.norm(v):
                found[i] = power, np.linalg.lstsq(basis, v, rcond=None)[0], len(kept)
                continue
            basis = np.column_stack([basis, v])
            frame = np.column_stack([frame, rest / np.linalg.norm(rest)])
            kept.append((i, power))
        tips, power = A @ tips, power + 1
    indices = tuple(found[i][0] for i in range(p))
    if len(kept) < n:
        raise EngineError("The plant is too nearly unobservable for a polynomial factorisation; measure more.")
    L = np.zeros((max(indices) + 1, p, p))
    for i, (degree, weights, count) in found.items():
        L[degree, i, i] = 1.0
        for (j, k), weight in zip(kept[:count], weights, strict=True):
            L[k, j, i] -= weight
    return indices, L


def _beyond(frame: np.ndarray, v: np.ndarray) -> np.ndarray:
    """What of v lies outside the span of the orthonormal columns of `frame`."""
    rest = v - frame @ (frame.T @ v)
    return rest - frame @ (frame.T @ rest)
