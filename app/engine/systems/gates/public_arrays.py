"""Check matrices, covariances and symmetric parts for callers outside the engine."""

from __future__ import annotations

import numpy as np

from .. import arrays
from .argument_checks import NAME, array, count, takes

__all__ = ["as_covariance", "as_matrix", "symmetric"]


@takes(size=count(), name=NAME)
def as_covariance(value: object, name: str, size: int) -> np.ndarray:
    """A symmetric positive semidefinite size×size matrix; a single number is that number times I.

    Raises ShapeError or EngineError with `name` in the sentence.
    """
    return arrays.as_covariance(value, name, size)


@takes(name=NAME)
def as_matrix(value: object, name: str) -> np.ndarray:
    """A finite, read-only, two-dimensional float array. Raises ShapeError or EngineError with `name` in the sentence."""
    return arrays.as_matrix(value, name)


@takes(matrix=array("… n n"))
def symmetric(matrix: np.ndarray) -> np.ndarray:
    """(M + Mᵀ)/2 of a matrix, or of each in a stack (…, n, n)."""
    return arrays.symmetric(matrix)
