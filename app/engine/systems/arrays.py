"""Matrices, covariances and weights: the one gate through which all rooms take them, in any units."""

from __future__ import annotations

import numpy as np

from .errors import EngineError, ShapeError

__all__ = ["as_covariance", "as_definite", "as_matrix", "as_weight", "correlations", "definite", "frozen",
           "solve_even", "symmetric"]

ASYMMETRY = 1e-9  # beside the roots of the diagonal entries; below ROUNDING of the largest entry nothing is said of it
ROUNDING = 1e-15
NEGATIVE = 1e-9  # how far below zero rounding may push an eigenvalue of the correlation matrix
LARGEST = 10_000_000  # entries of one matrix


def as_matrix(value: object, name: str) -> np.ndarray:
    """A finite, read-only, two-dimensional float array; `name` is used in the error sentence.

    Raises EngineError for text, ragged lists, imaginary parts, masked, NaN or infinite entries; ShapeError for others
    than two dimensions.
    """
    if np.ma.is_masked(value):
        raise EngineError("{name} has masked entries; every entry must be a finite number.", name=name)
    if np.size(value) > LARGEST if isinstance(value, np.ndarray) else False:
        raise ShapeError("{name} has more than {largest:.0e} entries; give a smaller matrix.",
                         name=name, largest=LARGEST)
    try:
        if isinstance(value, np.ndarray) and value.dtype.kind == "c":
            value = value if np.any(value.imag) else value.real
            value = value.tolist()  # NumPy drops the imaginary parts of an array, but not those of a list
        if (isinstance(value, np.ndarray) and value.dtype.kind in "SUmM") or isinstance(value, str | bytes):
            raise TypeError
        matrix = np.array(value, dtype=float, ndmin=2)
    except (TypeError, ValueError, OverflowError) as problem:
        raise EngineError("{name} must be a matrix of real numbers.", name=name) from problem
    if matrix.ndim != 2:
        raise ShapeError("{name} must have two dimensions, not {ndim}.", name=name, ndim=matrix.ndim)
    if not np.all(np.isfinite(matrix)):
        raise EngineError("{name} holds NaN or infinity; every entry must be a finite number.", name=name)
    matrix.setflags(write=False)  # the layout stays: a plant and its dual are rounded alike
    return matrix


def frozen(array: np.ndarray) -> np.ndarray:
    """The array in one piece and read-only, as a record keeps it; a copy where it was not in one piece."""
    array = np.ascontiguousarray(array)
    array.setflags(write=False)
    return array


def symmetric(matrix: np.ndarray) -> np.ndarray:
    """(M + Mᵀ)/2 of a matrix, or of each in a stack (…, n, n)."""
    return (matrix + matrix.swapaxes(-1, -2)) / 2


def correlations(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The correlations R (n×n) and the deviations d (n,) of a covariance d R d: units are in d alone. d_i = 1 where the
    variance is not positive."""
    spread = np.sqrt(np.abs(np.diag(matrix)))
    spread = np.where(spread > 0, spread, 1.0)
    return matrix / spread / spread[:, None], spread


def solve_even(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """X (n×k) of S X = right for a positive definite S (n×n), by its correlations: the units of S cost no digits."""
    even, spread = correlations(matrix)
    return np.linalg.solve(even, right / spread[:, None]) / spread[:, None]


def definite(matrix: np.ndarray) -> bool:
    """Whether a symmetric matrix is positive definite, by its correlations: diag(1e-18, 1) is."""
    if not len(matrix):
        return True
    if not np.diag(matrix).min() > 0:
        return False
    values = np.linalg.eigvalsh(correlations(matrix)[0])
    return bool(values[0] > ROUNDING * values[-1])


def as_covariance(value: object, name: str, size: int) -> np.ndarray:
    """A symmetric positive semidefinite size×size matrix; a single number is that number times I.

    Raises ShapeError or EngineError with `name` in the sentence.
    """
    matrix = as_matrix(value, name)
    if matrix.shape == (1, 1) and size != 1:
        matrix = matrix.item() * np.eye(size)
    matrix = _square_and_even(matrix, name, size)
    if _negative(matrix):
        raise EngineError("{name} has a negative eigenvalue; a covariance must be positive semidefinite.",
                          name=name)
    return frozen(matrix)


def as_weight(value: object, name: str, size: int) -> np.ndarray:
    """A symmetric positive semidefinite size×size weight, made exactly symmetric. Raises as `as_covariance` does."""
    matrix = _square_and_even(as_matrix(value, name), name, size)
    if _negative(matrix):
        raise EngineError("{name} has a negative eigenvalue; it must be positive semidefinite.", name=name)
    return frozen(matrix)


def as_definite(value: object, name: str, size: int) -> np.ndarray:
    """As `as_weight`, positive definite."""
    matrix = as_weight(value, name, size)
    if not definite(matrix):
        raise EngineError("{name} must be positive definite: every eigenvalue above zero.", name=name)
    return matrix


def _square_and_even(matrix: np.ndarray, name: str, size: int) -> np.ndarray:
    if matrix.shape != (size, size):
        raise ShapeError("{name} must be {size}×{size}; it is {rows}×{columns}.",
                         name=name, size=size, rows=matrix.shape[0], columns=matrix.shape[1])
    spread = np.sqrt(np.abs(np.diag(matrix)))
    allowed = np.maximum(ASYMMETRY * np.outer(spread, spread), ROUNDING * np.abs(matrix).max(initial=0.0))
    if np.any(np.abs(matrix - matrix.T) > allowed):
        raise EngineError("{name} must be symmetric; replace it by ({name} + {name}ᵀ)/2.", name=name)
    return symmetric(matrix)


def _negative(matrix: np.ndarray) -> bool:
    """Whether an eigenvalue lies below zero by more than rounding, in units of each entry's own."""
    if not len(matrix):
        return False
    return bool(np.diag(matrix).min() < 0 or np.linalg.eigvalsh(correlations(matrix)[0])[0] < -NEGATIVE * len(matrix))
