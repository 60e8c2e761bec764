"""Estimate the rounding error of a plant projected on fewer states."""

from __future__ import annotations

import numpy as np

from ..systems.exact_roots import MAX_STATES
from ..systems.fixed_point import fixed, number, product
from ..systems.plant import Plant

__all__ = ["projection_rounding_error"]

BITS = 400
SURPLUS = 4.0  # for what lies between the frequencies looked at
EPS = float(np.finfo(float).eps)


def projection_rounding_error(plant: Plant, reduced: Plant, T: np.ndarray, L: np.ndarray) -> float:
    """By how much the response of `reduced` differs from that of L A T, L B, C T with L T = I, to first order.

    A ≈ T z (n×r), z = L x (r×n). The differences E of the matrices are taken exactly; C (s − A)⁻¹ E (s − A)⁻¹ B and its like
    are then looked at for s = 0 and at the size of each pole. Of more than thirty states E is what it can be at most.
    """
    if not reduced.n:
        return 0.0
    A, B, C = reduced.A, reduced.B, reduced.C
    more_A, more_B, more_C = _differences(plant, reduced, T, L)
    poles = np.linalg.eigvals(A)
    points = np.exp(1j * np.angle(poles)) if plant.dt > 0 else 1j * np.concatenate([[0.0], np.abs(poles)])
    inverse = np.linalg.pinv(points[:, None, None] * np.eye(len(A)) - A)
    reach, show = inverse @ B, C @ inverse
    moved = show @ (more_A @ reach + more_B) + more_C @ reach
    return SURPLUS * float(np.linalg.norm(moved, 2, axis=(1, 2)).max())


def _differences(plant: Plant, reduced: Plant, T: np.ndarray, L: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    if plant.n > MAX_STATES:
        dust = plant.n * EPS
        return (dust * np.abs(L) @ np.abs(plant.A) @ np.abs(T), dust * np.abs(L) @ np.abs(plant.B), dust * np.abs(plant.C) @ np.abs(T))
    wide, tall = fixed(T, BITS), fixed(L, BITS)

    def projected(*factors: np.ndarray) -> np.ndarray:
        whole = factors[0]
        for factor in factors[1:]:
            whole = product(whole, factor, BITS)
        return whole

    def doubles(M: np.ndarray) -> np.ndarray:
        return np.real(number(M, 0 * M, BITS))
    A, B, C, one = (fixed(M, BITS) for M in (plant.A, plant.B, plant.C, np.eye(reduced.n)))
    slant = doubles(projected(tall, wide) - one)
    return (doubles(fixed(reduced.A, BITS) - projected(tall, A, wide)) + slant @ reduced.A,
            doubles(fixed(reduced.B, BITS) - projected(tall, B)) + slant @ reduced.B,
            doubles(fixed(reduced.C, BITS) - projected(C, wide)))
