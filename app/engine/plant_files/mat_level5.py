"""Read the variables of a MATLAB 5 (-v6, -v7) file without trusting one byte of it.

Why not scipy.io.loadmat: a single flipped byte in a file can end the whole process (bus error), and a small
compressed variable can unpack to gigabytes. Here every length is checked against what is left.
Source: "MAT-File Format", The MathWorks, chapter 1 (level 5).
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from types import MappingProxyType

import numpy as np

from ..systems.errors import EngineError, phrase
from .input_gate import MAX_STATES, OBJECT, Entry, Unread

__all__ = ["read_level5", "unreadable"]

_NUMBERS = MappingProxyType({1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"})
_TEXTS = MappingProxyType({1: "utf-8", 2: "utf-8", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"})
_MATRIX, _COMPRESSED, _COMPLEX = 14, 15, 0x0800
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE, _FUNCTION, _OPAQUE = 1, 2, 3, 4, 5, 16, 17
_FULL = range(6, 16)  # double, single, int8 … uint64
_DEEPEST, _MOST_PARTS = 6, 2000  # levels of structs and cells, and members of one


def unreadable() -> EngineError:
    """The error for a file that is no .mat file, or a damaged one."""
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
            raise unreadable()
        if body + size > len(data):
            raise unreadable()
        yield kind, data[body:body + size]
        place += step


def _numbers(element: tuple[int, bytes], order: str) -> np.ndarray:
    kind, raw = element
    if kind not in _NUMBERS:
        raise unreadable()
    return np.frombuffer(raw, order + _NUMBERS[kind])


def _characters(element: tuple[int, bytes], order: str) -> str:
    kind, raw = element
    suffix = {"<": "-le", ">": "-be"}[order] if _TEXTS[kind] != "utf-8" else ""
    return raw.decode(_TEXTS[kind] + suffix)


def _sparse(parts: Iterator[tuple[int, bytes]], shape: tuple[int, ...], order: str) -> Entry:
    """A sparse matrix as a full one, where it is small enough: row indices, starts of the columns, values."""
    if len(shape) != 2 or max(shape) > MAX_STATES or min(shape) < 0:
        return Unread(phrase("a sparse matrix of more than {most}×{most}", most=MAX_STATES))
    rows, starts = (_numbers(next(parts), order).astype(int) for _ in range(2))
    values = _numbers(next(parts, (9, b"")), order).astype(float)
    full = np.zeros(shape)
    for column in range(shape[1]):
        for place in range(int(starts[column]), int(starts[column + 1])):
            if not 0 <= rows[place] < shape[0]:
                raise unreadable()
            full[rows[place], column] += values[place]
    return full


def _struct(parts: Iterator[tuple[int, bytes]], shape: tuple[int, ...], order: str, depth: int) -> Entry:
    length = int(_numbers(next(parts), order)[0])
    _, raw = next(parts)
    if not 1 <= length <= 256:
        raise unreadable()
    names = [raw[i:i + length].split(b"\0")[0].decode("utf-8") for i in range(0, len(raw), length)]
    if int(np.prod(shape)) != 1:
        return Unread(phrase("an array of structs"))
    return {name: _member(next(parts), order, depth) for name in names[:_MOST_PARTS]}


def _cells(parts: Iterator[tuple[int, bytes]], shape: tuple[int, ...], order: str, depth: int) -> Entry:
    """A cell array as a list of rows."""
    if len(shape) != 2 or shape[0] * shape[1] > _MOST_PARTS:
        return Unread(phrase("a cell array"))
    found = [_member(next(parts), order, depth) for _ in range(shape[0] * shape[1])]
    return [[found[i + j * shape[0]] for j in range(shape[1])] for i in range(shape[0])]


def _member(element: tuple[int, bytes], order: str, depth: int) -> Entry:
    kind, payload = element
    if kind != _MATRIX:
        raise unreadable()
    return _variable(payload, order, depth + 1)[1] if payload else np.zeros((0, 0))


def _variable(payload: bytes, order: str, depth: int = 0) -> tuple[str, Entry]:
    """Name and value of one variable. An opaque one (an object of a newer class) has no dimensions before its name."""
    if depth > _DEEPEST:
        return "", Unread(phrase("a struct within a struct, too deep"))
    parts = _elements(payload, order)
    flags = int(_numbers(next(parts), order)[0])
    array_class = flags & 0xFF
    if array_class == _OPAQUE:
        name, _, of = (next(parts)[1].decode("ascii", "replace") for _ in range(3))
        return name, Unread(OBJECT, of)
    shape = tuple(int(size) for size in _numbers(next(parts), order))
    name = next(parts)[1].decode("utf-8")
    if len(shape) < 2 or min(shape) < 0:
        raise unreadable()
    return name, _value(array_class, flags, shape, parts, order, depth)


def _value(array_class: int, flags: int, shape: tuple[int, ...], parts: Iterator[tuple[int, bytes]], order: str,
           depth: int) -> Entry:
    if array_class == _OBJECT:
        return Unread(OBJECT, next(parts)[1].decode("ascii", "replace"))
    if array_class == _STRUCT:
        return _struct(parts, shape, order, depth)
    if array_class == _CELL:
        return _cells(parts, shape, order, depth)
    if array_class == _FUNCTION:
        return Unread(phrase("a function"))
    if array_class == _SPARSE and flags & _COMPLEX:
        return Unread(phrase("complex"))
    if array_class == _SPARSE:
        return _sparse(parts, shape, order)
    element = next(parts, (9 if array_class != _CHAR else 16, b""))
    if array_class == _CHAR:
        return _characters(element, order) if element[0] in _TEXTS else Unread(phrase("text"))
    if array_class not in _FULL or element[0] not in _NUMBERS:
        return Unread(phrase("of a kind that is not known"))
    if len(shape) != 2:
        return Unread(phrase("an array of {count} dimensions", count=len(shape)))
    real = _numbers(element, order).reshape(shape, order="F").astype(float)
    return real if not flags & _COMPLEX else real + 1j * _numbers(next(parts), order).reshape(shape, order="F")


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


def read_level5(data: bytes, limit: int) -> dict[str, Entry]:
    """Variables by name, in the order of the file. `limit`: the number of bytes that it may unpack to.

    Raises EngineError when the file is not MATLAB 5, is damaged, or unpacks beyond the limit.
    """
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    version = data[124:126] if order == ">" else data[125:123:-1]
    if order and version == b"\x02\x00":
        raise EngineError("This .mat file is of version 7.3; save it in MATLAB with the option -v7.")
    if order is None or version != b"\x01\x00":
        raise unreadable()
    try:
        found = dict(_variable(payload, order) for payload in _unpacked(data, order, limit))
    except (ValueError, IndexError, KeyError, RuntimeError, StopIteration, OverflowError, zlib.error) as problem:
        if isinstance(problem, EngineError):
            raise
        raise unreadable() from problem
    return {name: value for name, value in found.items() if name}  # what objects are made of has no name
