"""Compute the gains N̄ and K_I by which outputs follow a constant command."""

from __future__ import annotations

import numpy as np

from ..systems.arrays import as_checked, frozen
from ..systems.balance import state_scale
from ..systems.errors import EngineError
from ..systems.gates.argument_checks import matrix, number, optional, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record

__all__ = ["IntegralAction", "integral_action", "reference_gain"]

NEAR_ZERO = 1e-9  # of the sizes that are summed: a steady gain below it is rounding
EVEN_OUT = 8  # turns in which rows and columns are brought to like sizes
CLOSE = 1e-6  # how near G₀ N̄ must come to I


@record()
class IntegralAction:
    """u = −K x̂ + N̄ r + K_I x_I with ẋ_I = r − y (x_I⁺ = x_I + r − y for a sampled plant); K (m×n), K_I (m×p)."""

    K: np.ndarray
    K_I: np.ndarray


@takes(plant=PLANT, K=matrix("m n"))
def reference_gain(plant: Plant, K: object) -> np.ndarray:
    """N̄ (m×p) for u = −K x̂ + N̄ r, by which all outputs of the plant rest at the constant command r (p,).

    G₀ N̄ = I with the steady gain G₀ = D − (C − D K)(A − B K)⁻¹B from r to y, I − A + B K in place of −(A − B K) for a sampled plant.
    Of several solutions it is the one of least norm. Source: Franklin, Powell, Emami-Naeini, Feedback Control of Dynamic Systems,
    section 7.9. Raises EngineError where no constant input holds the outputs at r.

    >>> reference_gain(Plant([[-1]], [[2]], [[1]]), [[3]])
    array([[3.5]])
    """
    return _gains(plant, K)[0]


@takes(plant=PLANT, K=matrix("m n"), rate=number(above=0), N=optional(matrix("m p")))
def integral_action(plant: Plant, K: object, rate: float, *, N: object = None) -> IntegralAction:
    """K (m×n) and K_I (m×p) that add one pole at −rate for each output and leave the poles of A − B K where they are.

    With T (A − B K) = C − D K (T (A − B K − I) if sampled) the value ξ = x_I + T x obeys ξ̇ = −rate ξ (ξ⁺ = (1 − rate) ξ) under
    u = −K x + N̄ r + rate N̄ ξ. So K_I = rate N̄, and K − rate N̄ T stands in place of K: the placement of the plant with its integrators
    as more states. `rate` is in 1/s; for a sampled plant it is the share by which ξ shrinks in a step. N (m×p) is another N̄ with
    G₀ N̄ = I, such as one that keeps further outputs at zero; without it the one of least norm is taken. Source: Åström and Murray,
    Feedback Systems, section 7.4. Raises as `reference_gain` does, and for an N with G₀ N ≠ I.

    >>> integral_action(Plant([[-1]], [[1]], [[1]]), [[1]], 3.0).K_I
    array([[6.]])
    """
    least, T, steady, sizes = _gains(plant, K)
    chosen = least if N is None else as_checked(N)
    if not np.allclose((steady @ chosen) * sizes / sizes[:, None], np.eye(plant.p), atol=CLOSE):
        raise EngineError("N does not hold the outputs at a command; take it from reference_gain.")
    return IntegralAction(frozen(as_checked(K) - rate * chosen @ T), frozen(rate * chosen))


def _gains(plant: Plant, K: object) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """N̄ (m×p), T (p×n), the steady gain G₀ (p×m), and the sizes of the outputs (p,)."""
    K = as_checked(K)
    D = np.asarray(plant.D)
    still = plant.A - plant.B @ K - (np.eye(plant.n) if plant.dt else 0.0)
    x = state_scale(still)
    try:
        T = np.linalg.solve((still * x / x[:, None]).T, ((plant.C - D @ K) * x).T).T / x
    except np.linalg.LinAlgError as problem:
        raise EngineError("A − B K has a pole that holds a constant; move it before you ask for a steady output.") from problem
    steady = D - T @ plant.B
    parts, sizes, inputs = np.abs(D) + np.abs(T) @ np.abs(plant.B), np.ones(plant.p), np.ones(plant.m)
    for _ in range(EVEN_OUT):  # rows and columns in turn: which output and which input is in small units is not known
        sizes *= _largest(parts / inputs / sizes[:, None], 1)
        inputs *= _largest(parts / inputs / sizes[:, None], 0)
    even = steady / inputs / sizes[:, None]
    shares = np.linalg.svd(even, compute_uv=False)
    if plant.p > plant.m or shares.size == 0 or not shares[-1] > NEAR_ZERO:
        raise EngineError("No constant input holds the outputs at a command; choose other outputs, or more inputs.")
    least = np.linalg.inv(even) / inputs[:, None] / sizes if plant.p == plant.m else np.linalg.pinv(steady / sizes[:, None]) / sizes
    return least, T, steady, sizes


def _largest(parts: np.ndarray, axis: int) -> np.ndarray:
    found = parts.max(axis=axis, initial=0.0)
    return np.where(found > 0, np.sqrt(found), 1.0)
