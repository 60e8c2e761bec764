"""Model the univariate nonstationary growth model, a hard case for Gaussian filters.

x[k] = x/2 + 25 x/(1 + x²) + 8 cos(1.2 (k − 1)) + w, y = x²/20 + v, w and v of variance one: the sign of x is hidden from
the sensor. Gordon, Salmond and Smith (1993), after Kitagawa (1987). The input is the known cosine.
"""

from __future__ import annotations

import numpy as np

X0, P0 = 0.1, 1.0  # believed start, as in the toolbox whose table is compared


def drive(k: int) -> float:
    """The known input of the step that leads to sample k = 1, 2, …"""
    return 8 * float(np.cos(1.2 * (k - 1)))


def step(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """The next state without noise, columns x (1, N), u (1, 1)."""
    return x / 2 + 25 * x / (1 + x * x) + u


def step_expanded(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same with its slope (N, 1, 1)."""
    square = x * x
    return step(x, u), (0.5 + 25 * (1 - square) / (1 + square)**2).T[:, :, None]


def seen(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """The reading without noise."""
    return x * x / 20


def seen_expanded(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same with its slope (N, 1, 1)."""
    return seen(x, u), (x / 10).T[:, :, None]
