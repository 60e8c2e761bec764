"""Model two carts on a spring with two sensors, an example of a functional observer.

The encoder counts without error; the scale of the tachometer may be wrong. The state is (q₁, v₁, q₂, v₂), both masses are 1 kg.
"""

from __future__ import annotations

import numpy as np

from ..engine import Plant
from ..engine.observers import perturbations
from ..engine.structure import CoprimeFactors, coprime_factors
from .duan import Example

__all__ = ["CARTS", "STIFFNESS", "directions", "row"]

STIFFNESS = 9.0  # N/m
_PAIR = np.array([[-1.0, 1.0], [1.0, -1.0]])  # how the distance of the carts pushes both of them


def _joint(column: int) -> np.ndarray:
    """Direction of A: one more N/m (column 0) or N s/m (column 1) between the carts."""
    A = np.zeros((4, 4))
    A[np.ix_((1, 3), (column, column + 2))] = _PAIR
    return A


_PLANT = Plant(STIFFNESS * _joint(0) + np.eye(4, k=1) * [0, 1, 0, 1], np.array([[0.0], [1.0], [0.0], [0.0]]), np.eye(2, 4),
               name="two carts")
_FACTORS: CoprimeFactors = coprime_factors(_PLANT)
CARTS = Example(_PLANT, -np.array([[100.0, 14.0, -88.0, 8.0]]),
                perturbations(_PLANT, A=[_joint(0), _joint(1)], C=[np.eye(2, 4) * [0, 1, 0, 0]]),
                (0.5, 0.2), (0.05,), (0.1, 0.1, 0.1, 0.1), (0.0, 0.0))


def row(s: complex | np.ndarray) -> np.ndarray:
    """The rows t (4, …) of T for poles s with t₄ = 1 that takes no reading of the tachometer: l = (l₁, 0).

    The columns of q₂ and v₂ in t A − s t = l C give t₃ = s t₄ and t₂ = 1 + s²/k; the column of v₁ gives t₁ = s t₂ for l₂ = 0.
    """
    second = 1 + s * s / STIFFNESS
    return np.array([s * second, second, s, np.ones_like(second)])


def directions(poles: tuple[complex, ...]) -> np.ndarray:
    """The direction g (q, 2) of each pole with H(s) g = row(s): the freedom that a second output gives."""
    return np.array([np.linalg.lstsq(_FACTORS.H_at(s).astype(complex), row(s), rcond=None)[0] for s in map(complex, poles)])
