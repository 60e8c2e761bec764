"""Read the variables of a MATLAB 4 file (save -v4): a header of five numbers, the name, the numbers.

Source: "MAT-File Format", The MathWorks, chapter 2 (level 4).
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from ..systems.errors import phrase
from .input_gate import MAX_STATES, Entry, Unread
from .mat_level5 import unreadable

__all__ = ["is_level4", "read_level4"]

_PRECISION = MappingProxyType({0: "f8", 1: "f4", 2: "i4", 3: "i2", 4: "u2", 5: "u1"})
_FULL, _TEXT, _SPARSE = 0, 1, 2
_HEADER = 20  # bytes
_LONGEST_NAME = 64


def is_level4(data: bytes) -> bool:
    """Whether the file begins as one of level 4 does."""
    return len(data) >= _HEADER and _order(data) is not None


def _order(data: bytes) -> str | None:
    """The order of bytes, by the first number M·1000 + P·10 + T of the header, None where it is none."""
    for order, machine in (("<", 0), (">", 1)):
        kind, rows, columns, imaginary, name = np.frombuffer(data[:_HEADER], order + "i4").tolist()
        if (kind // 1000, kind // 100 % 10) == (machine, 0) and kind // 10 % 10 in _PRECISION and kind % 10 <= _SPARSE \
                and rows >= 0 and columns >= 0 and imaginary in (0, 1) and 1 < name <= _LONGEST_NAME:
            return order
    return None


def read_level4(data: bytes) -> dict[str, Entry]:
    """Variables by name. Raises EngineError where the file is damaged."""
    found: dict[str, Entry] = {}
    place = 0
    while place < len(data):
        order = _order(data[place:]) if len(data) - place >= _HEADER else None
        if order is None:
            raise unreadable()
        kind, rows, columns, imaginary, length = np.frombuffer(data[place:place + _HEADER], order + "i4").tolist()
        place += _HEADER
        name = data[place:place + length].split(b"\0")[0].decode("ascii", "replace")
        place += length
        number = np.dtype(order + _PRECISION[kind // 10 % 10])
        size = rows * columns * number.itemsize
        if place + size * (1 + imaginary) > len(data):
            raise unreadable()
        values = np.frombuffer(data[place:place + size], number).astype(float).reshape((rows, columns), order="F")
        if imaginary and kind % 10 == _FULL:
            values = values + 1j * np.frombuffer(data[place + size:place + 2 * size], number).reshape((rows, columns), order="F")
        place += size * (1 + imaginary)
        found[name] = _value(kind % 10, values)
    return found


def _value(kind: int, values: np.ndarray) -> Entry:
    if kind == _TEXT:
        return "".join(chr(int(code)) for code in values.ravel() if 0 <= code < 0x110000)
    if kind == _FULL:
        return values
    return _sparse(values)


def _sparse(triplets: np.ndarray) -> Entry:
    """A sparse matrix as a full one: rows (i, j, value), the last of which has its size."""
    if triplets.shape[1] == 4:
        return Unread(phrase("complex"))
    if triplets.shape[1] != 3 or not len(triplets) or not np.isfinite(triplets[:, :2]).all():
        raise unreadable()
    rows, columns = (int(size) for size in triplets[-1, :2])
    if not (0 <= rows <= MAX_STATES and 0 <= columns <= MAX_STATES):
        return Unread(phrase("a sparse matrix of more than {most}×{most}", most=MAX_STATES))
    full = np.zeros((rows, columns))
    for i, j, value in triplets[:-1]:
        if not (1 <= i <= rows and 1 <= j <= columns):
            raise unreadable()
        full[int(i) - 1, int(j) - 1] += value
    return full
