"""Check array arguments: matrices, covariances, vectors and poles with agreeing sizes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeGuard

import numpy as np

from ..arrays import as_covariance, as_matrix, as_numbers
from ..errors import EngineError, PoleError, ShapeError
from .checked_calls import Gate, Sizes

__all__ = ["POLES", "RECORD", "SERIES", "WHOLE", "array", "covariance", "matrix", "vector"]


def matrix(shape: str = "") -> Gate:
    """A finite real matrix, of a shape such as "n m" or "n 1" if given."""
    wanted = shape.split()

    def gate(value: object, name: str, sizes: Sizes) -> np.ndarray:
        found = value if _kept(value) else as_matrix(value, name)
        if wanted:
            _fit(found.shape, wanted, name, sizes)
        return found
    return gate


def _kept(value: object) -> TypeGuard[np.ndarray]:
    """Whether a value is a finite matrix that a record of the engine keeps: it need not be copied."""
    return (type(value) is np.ndarray and value.dtype == np.float64 and value.ndim == 2 and not value.flags.writeable
            and bool(np.isfinite(value).all()))


def covariance(size: str = "") -> Gate:
    """A symmetric positive semidefinite matrix; a number is that number times I where the size is known."""
    def gate(value: object, name: str, sizes: Sizes) -> np.ndarray:
        found, known = as_matrix(value, name), sizes.get(size)
        found = as_covariance(found, name, max(found.shape) if known is None else known)
        if size and found.shape != (1, 1):
            sizes.setdefault(size, len(found))
        return found
    return gate


def vector(size: str = "") -> Gate:
    """Finite real numbers in a row (or a column, or one alone)."""
    def gate(value: object, name: str, sizes: Sizes) -> np.ndarray:
        found = as_numbers(value, name)
        if found.size != max(found.shape, default=1):
            raise ShapeError("{name} must have one dimension, not {ndim}.", name=name, ndim=found.ndim)
        found = found.reshape(-1)
        if size and sizes.setdefault(size, found.size) != found.size:
            raise ShapeError("{name} must have {length} entries; it has {vector_size}.",
                             name=name, length=sizes[size], vector_size=found.size)
        return found
    return gate


def array(shape: str = "", *, imaginary: bool = False, missing: bool = False, infinite: bool = False, single: bool = False) -> Gate:
    """Finite numbers of a shape such as "… n n", where … are axes that may be there; NaN if they may be `missing`."""
    wanted = shape.split()

    def gate(value: object, name: str, sizes: Sizes) -> np.ndarray:
        found = as_numbers(value, name, missing=missing, imaginary=imaginary, infinite=infinite, single=single)
        if wanted[:1] == ["…"]:
            tail = wanted[1:]
            if found.ndim < len(tail):
                raise _misfit(found.shape, wanted, name, sizes)
            _fit(found.shape[found.ndim - len(tail):], tail, name, sizes)
        elif wanted:
            _fit(found.shape, wanted, name, sizes)
        return found
    return gate


def _fit(shape: tuple[int, ...], wanted: list[str], name: str, sizes: Sizes) -> None:
    if len(shape) != len(wanted):
        raise _misfit(shape, wanted, name, sizes)
    known = sizes.copy()
    for size, letter in zip(shape, wanted):  # noqa: B905 — as long as each other, and this is asked of every argument
        if known.setdefault(letter, size) != size or (letter.isdigit() and int(letter) != size):
            raise _misfit(shape, wanted, name, sizes)
    sizes |= known


def _misfit(shape: tuple[int, ...], wanted: list[str], name: str, sizes: Sizes) -> ShapeError:
    it_is = "×".join(map(str, shape)) or "1"
    if len(wanted) == 2 == len(shape) and wanted[0] == wanted[1] and wanted[0] not in sizes:
        return ShapeError("{name} must be square; it is {rows}×{columns}.", name=name, rows=shape[0], columns=shape[1])
    known = [sizes.get(letter) for letter in wanted]
    if len(wanted) == 2 == len(shape) and known.count(None) == 1:
        if known[0] is not None:
            return ShapeError("{name} must have {rows} rows; it is {it_is}.", name=name, rows=known[0], it_is=it_is)
        return ShapeError("{name} must have {columns} columns; it is {it_is}.", name=name, columns=known[1], it_is=it_is)
    must = "×".join(str(sizes.get(letter, letter)) for letter in wanted)
    return ShapeError("{name} must be {must}; it is {it_is}.", name=name, must=must, it_is=it_is)


def _whole(value: object, name: str, sizes: Sizes) -> np.ndarray:
    found = np.atleast_1d(as_numbers(value, name))
    if not np.all(found == np.rint(found)) or np.abs(found).max(initial=0.0) > 2**53:
        raise EngineError("{name} must hold whole numbers.", name=name)
    return found.astype(int)


def _series(value: object, name: str, sizes: Sizes) -> np.ndarray:
    found = np.atleast_1d(as_numbers(value, name))
    if found.ndim != 1:
        raise ShapeError("{name} must have one dimension, not {ndim}.", name=name, ndim=found.ndim)
    return found


def _poles(value: Any, name: str, sizes: Sizes) -> np.ndarray:
    whole = hasattr(value, "shape") or isinstance(value, str | bytes | set) or not isinstance(value, Iterable)
    listed = value if whole else list(value)  # of what has a shape each row would be made by itself: 11 s for a large sparse matrix
    try:
        found = np.atleast_1d(as_numbers(listed, name, imaginary=True, missing=True, infinite=True))
    except EngineError as problem:
        raise PoleError("The poles must be numbers, real or complex.") from problem
    if not np.isfinite(found).all():
        raise PoleError("A requested pole is NaN or infinite; every pole must be a finite number.")
    if found.ndim != 1:
        raise ShapeError("{name} must have one dimension, not {ndim}.", name=name, ndim=found.ndim)
    return found


WHOLE: Gate = _whole
SERIES: Gate = _series  # finite numbers, one or many: frequencies, values of a knob
POLES: Gate = _poles  # finite complex numbers
RECORD: Gate = array(missing=True)  # measurements; NaN or a masked entry did not arrive
