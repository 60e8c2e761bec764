"""Define model errors ΔA = Σ δᵢ Aᵢ, ΔC = Σ δᵢ Cᵢ, and the criterion J that weighs them."""

from __future__ import annotations

import itertools
from typing import Any, Literal

import numpy as np

from ..systems.arrays import frozen
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import array, choice, instance, matrix, takes, vector
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record

__all__ = ["Norm", "Perturbations", "criterion", "every_entry", "perturbations", "vertices"]

Norm = Literal[1, 2, "inf"]
MOST_VERTICES = 4096


@record()
class Perturbations:
    """Directions A (l_a, n, n) and C (l_c, p, n) of the model error, weights alpha (l_a,), beta and gamma (l_c,)."""

    A: np.ndarray
    C: np.ndarray
    alpha: np.ndarray
    beta: np.ndarray
    gamma: np.ndarray


@takes(plant=PLANT, A=array(), C=array(), alpha=vector(), beta=vector(), gamma=vector())
def perturbations(plant: Plant, *, A: Any = (), C: Any = (), alpha: Any = 1.0, beta: Any = 1.0,
                  gamma: Any = 1.0) -> Perturbations:
    """Known directions Aᵢ (n×n) and Cᵢ (p×n) of ΔA = Σ δᵃᵢ Aᵢ, ΔC = Σ δᶜᵢ Cᵢ with weights αᵢ, βᵢ, γᵢ ≥ 0 (or one each).

    Raises ShapeError where a direction does not fit the plant, EngineError for a weight that is negative.
    Source: Duan, Li, Zhou (1993), (5), (6).
    """
    in_A, in_C = _stack(A, "A", (plant.n, plant.n)), _stack(C, "C", (plant.p, plant.n))
    return Perturbations(in_A, in_C, _weights(alpha, "alpha", len(in_A)), _weights(beta, "beta", len(in_C)),
                         _weights(gamma, "gamma", len(in_C)))


@takes(plant=PLANT)
def every_entry(plant: Plant) -> Perturbations:
    """Each non-zero entry of A and of C wrong by itself, in proportion to its size; all weights 1."""
    def each(matrix: np.ndarray) -> list[np.ndarray]:
        out = []
        for i, j in np.argwhere(matrix):
            single = np.zeros_like(matrix)
            single[i, j] = matrix[i, j]
            out.append(single)
        return out

    return perturbations(plant, A=each(plant.A), C=each(plant.C))


def _stack(given: Any, name: str, shape: tuple[int, int]) -> np.ndarray:
    try:
        stack = np.array(given, dtype=float) if len(given) else np.zeros((0, *shape))
    except (TypeError, ValueError) as problem:
        raise ShapeError("Every direction of Δ{name} must be a matrix {shape}×{shape2}.",
                         name=name, shape=shape[0], shape2=shape[1]) from problem
    if stack.ndim != 3 or stack.shape[1:] != shape:
        raise ShapeError("Every direction of Δ{name} must be a matrix {shape}×{shape2}.",
                         name=name, shape=shape[0], shape2=shape[1])
    if not np.isfinite(stack).all():
        raise EngineError("A direction of Δ{name} holds NaN or infinity.", name=name)
    return frozen(stack)


def _weights(given: Any, name: str, count: int) -> np.ndarray:
    try:
        weights = np.array(np.broadcast_to(np.asarray(given, dtype=float), (count,)))
    except (TypeError, ValueError) as problem:
        raise ShapeError("{name} must be one number or {count} numbers, one for each direction.",
                         name=name, count=count) from problem
    if not np.isfinite(weights).all() or np.any(weights < 0):
        raise EngineError("{name} must hold finite numbers that are not negative.", name=name)
    return frozen(weights)


def sizes(stack: np.ndarray, norm: Norm) -> np.ndarray:
    """The norm of every matrix of a stack (l, r, c): column sum (1), spectral (2) or row sum ("inf")."""
    if not len(stack):
        return np.zeros(0)
    if norm == 2 and 1 not in stack.shape[1:]:
        return np.linalg.norm(stack, 2, axis=(1, 2))
    if norm == 2:
        return np.sqrt(np.sum(stack * stack, axis=(1, 2)))
    return np.max(np.sum(np.abs(stack), axis=1 if norm == 1 else 2), axis=1)


def check_norm(norm: Any) -> Norm:
    """1, 2 or "inf" (∞ as a number is taken too). Raises EngineError otherwise."""
    if norm in ("inf", np.inf):
        return "inf"
    if norm in (1, 2):
        return 1 if norm == 1 else 2
    raise EngineError("norm must be 1, 2 or \"inf\".")


@takes(T=matrix("q n"), L=matrix("q p"), M=matrix("r p"), wrong=instance(Perturbations), norm=choice(1, 2, "inf"))
def criterion(T: np.ndarray, L: np.ndarray, M: np.ndarray, wrong: Perturbations, *, norm: Norm = 2) -> float:
    """J = Σ [αᵢ ‖T Aᵢ‖ + βᵢ ‖L Cᵢ‖ + γᵢ ‖M Cᵢ‖] for T q×n, L q×p, M r×p.

    J depends on the coordinates of the observer and does not see N: compare only observers whose rows of T were
    scaled alike. Source: Duan, Li, Zhou (1993), (6).
    """
    if wrong.A.shape[1:] != (T.shape[1],) * 2 or wrong.C.shape[1:] != (L.shape[1], T.shape[1]):
        raise ShapeError("T q×n, L q×p and M r×p must fit the perturbations of a plant with {n} states and {p} outputs.",
                         n=wrong.A.shape[1], p=wrong.C.shape[1])
    return float(wrong.alpha @ sizes(T @ wrong.A, norm) + wrong.beta @ sizes(L @ wrong.C, norm)
                 + wrong.gamma @ sizes(M @ wrong.C, norm))


@takes(wrong=instance(Perturbations), delta_A=vector(), delta_C=vector())
def vertices(wrong: Perturbations, delta_A: Any, delta_C: Any) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """(ΔA, ΔC) at all sign patterns of the sizes δᵃ (l_a,), δᶜ (l_c,): 2^(l_a + l_c) pairs, all-plus first.

    Raises EngineError where there are more than 4096.
    """
    a, c = _weights(np.abs(delta_A), "delta_A", len(wrong.A)), _weights(np.abs(delta_C), "delta_C", len(wrong.C))
    if 2 ** (a.size + c.size) > MOST_VERTICES:
        raise EngineError("{a_size} perturbations have too many sign patterns; keep to 12.", a_size=a.size + c.size)
    signs = itertools.product((1.0, -1.0), repeat=a.size + c.size)
    return tuple((np.tensordot(a * s[:a.size], wrong.A, 1), np.tensordot(c * s[a.size:], wrong.C, 1)) for s in
                 map(np.array, signs))
