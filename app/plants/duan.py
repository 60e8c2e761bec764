"""Model both examples of the robust Luenberger observer: plant, gains, model errors.

Source: Duan, Li, Zhou, "Robust Luenberger observer design" (1993), where u = +K x. `K_printed` is its K; ours is
K = −K_printed, so that u = −K x is the same control.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..engine import Plant
from ..engine.observers import Perturbations, perturbations

__all__ = ["EXAMPLE_1", "EXAMPLE_2", "Example", "outer_input"]


@dataclass(frozen=True, eq=False)
class Example:
    """One example. `wrong`: what may be wrong, weights 1; delta_A, delta_C: the sizes simulated in its figure, one for
    each direction of `wrong`; x0, z0: the starts; turn: the W of its figure (None if it has none)."""

    plant: Plant
    K_printed: np.ndarray
    wrong: Perturbations
    delta_A: tuple[float, ...]
    delta_C: tuple[float, ...]
    x0: tuple[float, ...]
    z0: tuple[float, ...]
    turn: np.ndarray | None = None

    @property
    def K(self) -> np.ndarray:
        """The gain in our sign, u = −K x."""
        return -self.K_printed

    @property
    def dA(self) -> np.ndarray:
        """ΔA of the figure."""
        return np.tensordot(self.delta_A, self.wrong.A, 1)

    @property
    def dC(self) -> np.ndarray:
        """ΔC of the figure."""
        return np.tensordot(self.delta_C, self.wrong.C, 1)


def outer_input(t: np.ndarray) -> np.ndarray:
    """The outer input of all figures: v = −4 sin(5t + π/2)."""
    return -4.0 * np.sin(5.0 * np.asarray(t) + np.pi / 2)


def _entry(n: int, row: int, column: int, value: float = 1.0) -> np.ndarray:
    matrix = np.zeros((n, n))
    matrix[row, column] = value
    return matrix


_PLANT_1 = Plant(np.array([[0, -3], [1, -4]]), np.array([[2], [1]]), np.array([[0, 1]]), name="Duan 1")
EXAMPLE_1 = Example(
    _PLANT_1, np.array([[-30.0, 50.0]]),
    perturbations(_PLANT_1, A=[_entry(2, 1, 0), _entry(2, 1, 1)], C=[np.array([[0.0, 1.0]])]),
    (0.1, -0.4), (0.05,), (1.0, 1.0), (-0.3,))

_PLANT_2 = Plant(np.array([[0, 1, 0], [0, 0, 1], [0, -2, -3]]), np.array([[0], [0], [1]]), np.array([[1, 0, 0]]),
                 name="Duan 2")  # a0 = 0, a1 = 2, a2 = 3, b = c = 1
EXAMPLE_2 = Example(
    _PLANT_2, np.array([[-4.0, -4.0, -1.0]]),
    perturbations(_PLANT_2, A=[_entry(3, 2, 1, -1.0), _entry(3, 2, 2, -1.0)], C=[np.array([[1.0, 0.0, 0.0]])]),
    (0.01, 0.05), (0.03,), (0.1, 0.1, 0.1), (0.1, 2.19), np.array([[1.0, 1.2], [0.0, 1.0]]))
