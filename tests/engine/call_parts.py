"""What the right calls are made of: a small plant's matrices, maps of one state, methods of a record."""

from __future__ import annotations

from typing import Any

import numpy as np

A, B, C = np.array([[0.0, 1.0], [-2.0, -3.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
I2, ONE = np.eye(2), np.eye(1)


def of(record: Any, name: str, **methods: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Calls of methods of a record, the record itself under "self"."""
    return {f"{name}.{method}": {"self": record, **arguments} for method, arguments in methods.items()}


def rhs(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return -x


def slope(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return -np.ones((x.shape[1], 1, 1))


def same(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return x


def ones(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return np.ones((x.shape[1], 1, 1))


def expand(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return x, np.ones((x.shape[1], 1, 1))
