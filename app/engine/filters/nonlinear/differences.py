"""Take differences of states and readings of which some are angles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...systems.gates.argument_checks import count, items, takes

__all__ = ["Combine", "angles", "minus", "plus"]

Combine = Callable[[np.ndarray, np.ndarray], np.ndarray]


@takes(rows=items(count(0, 1000)))
def angles(rows: tuple[int, ...]) -> Combine:
    """The difference a − b of states or readings whose `rows` are angles in rad: these come back between −π and π.

    For `y_minus` and `x_minus` of `ExtendedKalmanFilter` and `UnscentedKalmanFilter`; rows count from 0.

    >>> angles([1])(np.array([1.0, 3.0]), np.array([0.5, -3.0])).round(4)
    array([ 0.5   , -0.2832])
    """
    turned = list(rows)

    def minus(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        found = np.array(np.subtract(a, b))
        found[turned] -= 2 * np.pi * np.round(found[turned] / (2 * np.pi))
        return found

    return minus


def minus(combine: Combine | None, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a − b, by the user's own function where there is one."""
    return a - b if combine is None else np.asarray(combine(a, b))


def plus(combine: Combine | None, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a + b, by the user's own function where there is one."""
    return a + b if combine is None else np.asarray(combine(a, b))
