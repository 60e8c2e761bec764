"""Turn arguments into finite, read-only matrices, covariances and weights, in any units."""

from __future__ import annotations

import math
from collections.abc import Sized
from functools import lru_cache
from numbers import Complex, Real
from typing import Any, cast

import numpy as np
from scipy.linalg.lapack import dpotrf  # pyright: ignore[reportAttributeAccessIssue]

from .errors import EngineError, ShapeError, phrase

__all__ = ["all_finite", "as_checked", "as_covariance", "as_definite", "as_matrix", "as_numbers", "as_weight", "correlations", "described",
           "frozen", "is_definite", "solve_scaled", "symmetric"]

ASYMMETRY = 1e-9  # beside the roots of the diagonal entries; below EIGENVALUE_ROUNDING of the largest entry nothing is said of it
EIGENVALUE_ROUNDING = 1e-15
LEAST_DEVIATION = 1e-146  # a smaller one has a variance that lost its digits at the end of the range of doubles
NEGATIVE = 1e-9  # how far below zero rounding may push an eigenvalue of the correlation matrix
MAX_ENTRIES = 10_000_000  # entries of one matrix
FEW = 16  # entries that Python looks at sooner than NumPy
CACHED_ENTRIES = 1024  # entries: a weight or covariance up to this size is judged once, however often a loop is built from it


def as_numbers(value: object, name: str, *, missing: bool = False, imaginary: bool = False,
               infinite: bool = False, single: bool = False) -> np.ndarray:
    """Numbers in an array of any shape, doubles (or as `single` as they are) or complex; finite, but NaN where
    a value is `missing` if that may be.

    Sparse matrices are filled; masked entries are missing ones.
    Raises EngineError with `name` in it for text, dates, ragged lists, imaginary parts
    (unless `imaginary`), masked or NaN entries (unless `missing`) and infinity (unless `infinite`), ShapeError for more entries than memory
    should hold.
    """
    if type(value) is np.ndarray and not imaginary and value.dtype == np.float64 and value.size <= MAX_ENTRIES and np.isfinite(value).all():
        return value
    if isinstance(value, np.ma.MaskedArray):
        value = _unmasked(value, name, missing)
    if type(value).__module__.startswith("scipy.sparse"):
        value = _whole(value, name)
    count = value.size if isinstance(value, np.ndarray) else len(value) if isinstance(value, Sized) else 1
    if count > MAX_ENTRIES:
        raise ShapeError("{name} has more than {largest:.0e} entries; give a smaller matrix.", name=name, largest=MAX_ENTRIES)
    array = _plain(value, name)
    if array.dtype.kind == "c" and not imaginary:
        if np.imag(array).any():
            raise EngineError("{name} has imaginary parts; every entry must be a real number.", name=name)
        array = np.real(array)
    if imaginary:
        array = array.astype(complex, copy=False)
    elif not (single and array.dtype == np.float32):
        array = array.astype(float, copy=False)
    fine = ~np.isnan(array) if infinite else np.isfinite(array)
    if not (fine | np.isnan(array) if missing else fine).all():
        if missing:
            raise EngineError("{name} holds infinity; cut the record where it diverged.", name=name)
        raise EngineError("{name} holds NaN or infinity; every entry must be a finite number.", name=name)
    return array


def _unmasked(value: np.ma.MaskedArray, name: str, missing: bool) -> np.ndarray:
    if not np.ma.is_masked(value):
        return value.data
    if not missing or value.dtype.kind not in "fiub":
        raise EngineError("{name} has masked entries; every entry must be a finite number.", name=name)
    return np.ma.filled(value.astype(float), np.nan)


def _whole(value: Any, name: str) -> object:
    """A sparse matrix of SciPy with its zeros; any other of its things as it is."""
    if not hasattr(value, "toarray"):
        return value
    if math.prod(value.shape) > MAX_ENTRIES:
        raise ShapeError("{name} has more than {largest:.0e} entries; give a smaller matrix.", name=name, largest=MAX_ENTRIES)
    return value.toarray()


def _plain(value: object, name: str) -> np.ndarray:
    """The array that a value is, of booleans, integers, floats or complex numbers; no subclass, whose * may be another."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiubc":
        return np.asarray(value)
    try:
        array = np.asarray(value)
        if array.dtype.kind == "O" and all(isinstance(v, Complex) for v in array.flat):  # fractions, integers beyond 64 bits
            array = array.astype(float if all(isinstance(v, Real) for v in array.flat) else complex)
    except (TypeError, ValueError, OverflowError) as problem:
        raise EngineError("{name} must be a matrix of real numbers; {given} was given.", name=name, given=described(value)) from problem
    if array.dtype.kind not in "fiubc":
        raise EngineError("{name} must be a matrix of real numbers; {given} was given.", name=name, given=described(value))
    return array


def as_matrix(value: object, name: str) -> np.ndarray:
    """A finite, read-only, two-dimensional float array; `name` is used in the error sentence.

    Raises EngineError for text, ragged lists, imaginary parts, masked, NaN or infinite entries; ShapeError for others
    than two dimensions.
    """
    matrix = np.array(as_numbers(value, name), dtype=float, ndmin=2)
    if matrix.ndim != 2:
        raise ShapeError("{name} must have two dimensions, not {ndim}.", name=name, ndim=matrix.ndim)
    matrix.setflags(write=False)  # the layout stays: a plant and its dual are rounded alike
    return matrix


def all_finite(vector: np.ndarray) -> bool:
    """Whether every entry (n,) is finite; of a short vector in a third of NumPy's time."""
    return all(map(math.isfinite, vector.tolist())) if vector.size <= FEW else bool(np.isfinite(vector).all())


def as_checked(value: object) -> np.ndarray:
    """The argument as the array that its gate has made of it; nothing is done, but the type checker knows."""
    return cast(np.ndarray, value)


def frozen(array: np.ndarray) -> np.ndarray:
    """The array in one piece and read-only, as a record keeps it; a copy where it was not in one piece."""
    array = np.ascontiguousarray(array)
    array.setflags(write=False)
    return array


def symmetric(matrix: np.ndarray) -> np.ndarray:
    """(M + Mᵀ)/2 of a matrix, or of each in a stack (…, n, n)."""
    half = matrix * 0.5  # the sum of two of the largest numbers is none
    return half + (half.T if half.ndim == 2 else half.swapaxes(-1, -2))


def correlations(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The correlations R (n×n) and the deviations d (n,) of a covariance d R d: units are in d alone. d_i = 1 where the
    variance is not positive."""
    spread = np.sqrt(np.abs(np.diag(matrix)))
    spread = np.where(spread > LEAST_DEVIATION, spread, 1.0)
    return matrix / spread / spread[:, None], spread


def solve_scaled(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """X (n×k) of S X = right for a positive definite S (n×n), by its correlations: the units of S cost no digits."""
    even, spread = correlations(matrix)
    return np.linalg.solve(even, right / spread[:, None]) / spread[:, None]


def is_definite(matrix: np.ndarray) -> bool:
    """Whether a symmetric matrix is positive definite, by its correlations: diag(1e-18, 1) is."""
    if not len(matrix):
        return True
    return (_kept_definite if matrix.size <= CACHED_ENTRIES else _definite)(matrix.tobytes(), len(matrix))


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
    if not is_definite(matrix):
        raise EngineError("{name} must be positive definite: every eigenvalue above zero.", name=name)
    return matrix


def _square_and_even(matrix: np.ndarray, name: str, size: int) -> np.ndarray:
    if matrix.shape != (size, size):
        raise ShapeError("{name} must be {size}×{size}; it is {rows}×{columns}.",
                         name=name, size=size, rows=matrix.shape[0], columns=matrix.shape[1])
    if not (_kept_symmetry if matrix.size <= CACHED_ENTRIES else _symmetry)(matrix.tobytes(), size):
        raise EngineError("{name} must be symmetric; replace it by ({name} + {name}ᵀ)/2.", name=name)
    return symmetric(matrix)


def _symmetry(entries: bytes, size: int) -> bool:
    """Whether a matrix is symmetric but for rounding."""
    matrix = np.frombuffer(entries).reshape(size, size)
    if (matrix == matrix.T).all():
        return True
    spread = np.sqrt(np.abs(np.diag(matrix)))
    allowed = np.maximum(ASYMMETRY * np.outer(spread, spread), EIGENVALUE_ROUNDING * np.abs(matrix).max(initial=0.0))
    return not np.any(np.abs(matrix - matrix.T) > allowed)


def _negative(matrix: np.ndarray) -> bool:
    """Whether an eigenvalue lies below zero by more than rounding, in units of each entry's own."""
    if not len(matrix):
        return False
    return (_kept_sign if matrix.size <= CACHED_ENTRIES else _sign)(matrix.tobytes(), len(matrix))


def _sign(entries: bytes, size: int) -> bool:
    matrix = np.frombuffer(entries).reshape(size, size)
    if np.diag(matrix).min() < 0:
        return True
    even = correlations(matrix)[0]
    if not dpotrf(even + 0.5 * NEGATIVE * size * np.eye(size))[1]:  # a factor proves it in a tenth of the time of eigenvalues
        return False
    return bool(np.linalg.eigvalsh(even)[0] < -NEGATIVE * size)


def _definite(entries: bytes, size: int) -> bool:
    matrix = np.frombuffer(entries).reshape(size, size)
    if not np.diag(matrix).min() > 0:
        return False
    values = np.linalg.eigvalsh(correlations(matrix)[0])
    return bool(values[0] > EIGENVALUE_ROUNDING * values[-1])


_kept_symmetry, _kept_sign, _kept_definite = (lru_cache(maxsize=256)(judge) for judge in (_symmetry, _sign, _definite))


def described(value: object) -> str:
    """A value in three or four words: "an array of shape (2,)", "a list of 3 entries", "text", "None", else its kind."""
    if value is None:
        return "None"
    if isinstance(value, np.ndarray):
        return phrase("an array of shape {shape}", shape=str(value.shape))
    if isinstance(value, list | tuple | set | dict):
        return phrase("a {kind} of {count} entries", kind=type(value).__name__, count=len(value))
    if isinstance(value, str | bytes):
        return phrase("text")
    if isinstance(value, bool | int | float | complex | np.number):
        return phrase("the number {value}", value=str(value)[:20])
    return phrase("a {kind}", kind=type(value).__name__[:40])
