"""Matrices that must be symmetric or covariances: the checks that all rooms share."""

from __future__ import annotations

import numpy as np

from .errors import EngineError, ShapeError
from .plant import as_matrix

__all__ = ["as_covariance", "symmetric"]

ASYMMETRY = 1e-9  # relative to the largest entry
NEGATIVE = 1e-9  # how far below zero rounding may push an eigenvalue of the correlation matrix


def symmetric(matrix: np.ndarray) -> np.ndarray:
    """(M + Mᵀ)/2 of a matrix, or of each in a stack (…, n, n)."""
    return (matrix + matrix.swapaxes(-1, -2)) / 2


def as_covariance(value: object, name: str, size: int) -> np.ndarray:
    """A symmetric positive semidefinite size×size matrix; a single number is that number times I.

    Raises ShapeError or EngineError with `name` in the sentence.
    """
    matrix = as_matrix(value, name)
    if matrix.shape == (1, 1) and size != 1:
        matrix = matrix.item() * np.eye(size)
    if matrix.shape != (size, size):
        raise ShapeError("{name} must be {size}×{size}; it is {rows}×{columns}.",
                         name=name, size=size, rows=matrix.shape[0], columns=matrix.shape[1])
    if np.abs(matrix - matrix.T).max(initial=0.0) > ASYMMETRY * np.abs(matrix).max(initial=0.0):
        raise EngineError("{name} must be symmetric; replace it by ({name} + {name}ᵀ)/2.", name=name)
    matrix = symmetric(matrix)
    spread = np.sqrt(np.abs(np.diag(matrix)))
    divisor = np.where(spread > 0, spread, 1.0)
    if size and (np.diag(matrix).min() < 0
                 or np.linalg.eigvalsh(matrix / np.outer(divisor, divisor))[0] < -NEGATIVE * size):
        raise EngineError("{name} has a negative eigenvalue; a covariance must be positive semidefinite.",
                          name=name)
    matrix.setflags(write=False)
    return matrix
