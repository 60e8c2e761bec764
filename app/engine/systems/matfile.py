"""Read matrices and texts of a MATLAB 5 file without trusting any byte.

Why not scipy.io.loadmat: a single flipped byte in a file can end the whole process (bus error), and a small
compressed variable can unpack to gigabytes. Here every length is checked against what is left.
Source: "MAT-File Format", The MathWorks, chapter 1 (level 5).
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from types import MappingProxyType

import numpy as np

from .errors import EngineError

__all__ = ["read_mat"]

_NUMBERS = MappingProxyType({1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"})
_TEXTS = MappingProxyType({1: "utf-8", 2: "utf-8", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"})
_MATRIX, _COMPRESSED, _CHAR, _COMPLEX = 14, 15, 4, 0x0800
_FULL = range(6, 16)  # double, single, int8 … uint64

def _unreadable() -> EngineError:
    return EngineError("This is not a readable .mat file; save A, B, C, D with MATLAB's save -v7.")


def _elements(data: bytes, order: str, start: int = 0) -> Iterator[tuple[int, bytes]]:
    """(type, payload) of each data element; small elements carry type and size in one word."""
    word = "little" if order == "<" else "big"
    place = start
    while place + 8 <= len(data):
        first = int.from_bytes(data[place:place + 4], word)
        kind, size, body, step = first & 0xFFFF, first >> 16, place + 4, 8
        if size == 0:
            size, body = int.from_bytes(data[place + 4:place + 8], word), place + 8
            step = 8 + size + (0 if kind == _COMPRESSED else -size % 8)
        elif size > 4:
            raise _unreadable()
        if body + size > len(data):
            raise _unreadable()
        yield kind, data[body:body + size]
        place += step


def _value(kind: int, flags: int, shape: np.ndarray, raw: bytes, order: str) -> np.ndarray | str | None:
    """A matrix, a text, or None for what is neither full nor real."""
    array_class = flags & 0xFF
    if array_class == _CHAR and kind in _TEXTS:
        suffix = {"<": "-le", ">": "-be"}[order] if _TEXTS[kind] != "utf-8" else ""
        return raw.decode(_TEXTS[kind] + suffix)
    if array_class not in _FULL or flags & _COMPLEX or kind not in _NUMBERS:
        return None
    if shape.size != 2 or shape.min() < 0:
        return None
    return np.frombuffer(raw, order + _NUMBERS[kind]).reshape(tuple(shape.tolist()), order="F").astype(float)


def _variable(payload: bytes, order: str) -> tuple[str, np.ndarray | str | None]:
    parts = _elements(payload, order)
    (_, flags), (_, shape), (_, name) = (next(parts) for _ in range(3))
    kind, raw = next(parts, (0, b""))
    return name.decode("ascii"), _value(kind, int(np.frombuffer(flags, order + "u4")[0]),
                                        np.frombuffer(shape, order + "i4"), raw, order)


def _unpacked(data: bytes, order: str, limit: int) -> Iterator[bytes]:
    total = 0
    for kind, payload in _elements(data, order, 128):
        if kind == _COMPRESSED:
            inside = zlib.decompressobj().decompress(payload, limit + 1)
            total += len(inside)
            if total > limit:
                raise EngineError("The file unpacks to more than {limit:g} MB; a plant needs far less.",
                                  limit=limit / 1000000.0)
            kind, payload = next(_elements(inside, order), (0, b""))
        if kind == _MATRIX and payload:
            yield payload


def read_mat(data: bytes, limit: int) -> dict[str, np.ndarray | str | None]:
    """Variables by name: a float array (r×c), a str, or None where the variable is of any other kind.

    `data` is the whole file, `limit` the number of bytes it may unpack to.
    Raises EngineError when the file is not MATLAB 5, is damaged, or unpacks beyond the limit.
    """
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    version = data[124:126] if order == ">" else data[125:123:-1]
    if order and version == b"\x02\x00":
        raise EngineError("This .mat file is of version 7.3; save it in MATLAB with the option -v7.")
    if order is None or version != b"\x01\x00":
        raise _unreadable()
    try:
        return dict(_variable(payload, order) for payload in _unpacked(data, order, limit))
    except (ValueError, IndexError, RuntimeError, StopIteration, OverflowError, zlib.error) as problem:
        if isinstance(problem, EngineError):
            raise
        raise _unreadable() from problem
