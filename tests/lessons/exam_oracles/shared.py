"""What several computations need."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

Given = Mapping[str, Any]
INTEGRATOR, POSITION = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[1.0, 0.0]])


def placed(A: np.ndarray, C: np.ndarray, poles: list[float]) -> np.ndarray:
    """The observer gain of one output, from the coefficients of the polynomial: linear in L."""
    n = len(A)
    base = np.poly(A)[1:]
    slopes = np.column_stack([np.poly(A - np.outer(np.eye(n)[:, i], C))[1:] - base for i in range(n)])
    return np.linalg.solve(slopes, np.poly(poles)[1:] - base)


def spring(b: float, k: float) -> np.ndarray:
    return np.array([[0.0, 1.0], [-k, -b]])
