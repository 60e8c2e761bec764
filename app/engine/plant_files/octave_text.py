"""Read the variables of a text file that Octave saves (save -text, its default).

A header "# key: value", then numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType

import numpy as np

from ..systems.errors import EngineError, phrase
from .input_gate import MAX_STATES, OBJECT, Entry, Unread

__all__ = ["is_octave_text", "read_octave_text"]

_DEEPEST, _MOST_PARTS = 6, 2000
_WHOLE = tuple(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))


def is_octave_text(data: bytes) -> bool:
    """Whether the file begins as a text of Octave does."""
    return data.lstrip()[:20].startswith((b"# Created by Octave", b"# name: "))


def read_octave_text(text: str) -> dict[str, Entry]:
    """Variables by name. Raises EngineError where the text is not as Octave writes it."""
    lines = _Lines(text.splitlines())
    found: dict[str, Entry] = {}
    try:
        while (name := lines.next_name()) is not None:
            found[name] = _variable(lines, 0)
    except (ValueError, IndexError, OverflowError) as problem:
        if isinstance(problem, EngineError):
            raise
        raise EngineError("This is not a readable text of Octave: look near line {line}, or save it with save -v7.",
                          line=min(lines.place + 1, len(lines.lines))) from problem
    return found


class _Lines:
    """The lines of the text and how far it is read."""

    def __init__(self, lines: list[str]) -> None:
        self.lines, self.place = lines, 0

    def take(self) -> str:
        """The next line."""
        self.place += 1
        return self.lines[self.place - 1]

    def next_name(self) -> str | None:
        """The name of the next variable, None at the end; anything else before it is skipped."""
        while self.place < len(self.lines):
            line = self.take()
            if line.startswith("# name: "):
                return line.removeprefix("# name: ").strip()
        return None

    def header(self, key: str) -> str:
        """The value of the next line, which must be the header `key`."""
        line = self.take()
        if not line.startswith(f"# {key}:"):
            raise ValueError(line)
        return line.partition(":")[2].strip()

    def size(self) -> tuple[int, ...]:
        """Rows and columns, or the sizes of an array of more dimensions."""
        if self.lines[self.place].startswith("# ndims:"):
            self.take()
            return tuple(int(word) for word in self.take().split())
        return int(self.header("rows")), int(self.header("columns"))

    def numbers(self, rows: int) -> list[list[float]]:
        """So many lines of numbers."""
        return [[float(word) for word in self.take().split()] for _ in range(rows)]


def _full(lines: _Lines) -> Entry:
    listed = lines.lines[lines.place].startswith("# ndims:")  # then one number a line, column by column
    shape = lines.size()
    if len(shape) != 2:
        return Unread(phrase("an array of {count} dimensions", count=len(shape)))
    rows, columns = shape
    if listed:
        return np.array([float(lines.take()) for _ in range(rows * columns)]).reshape((rows, columns), order="F")
    return np.array(lines.numbers(rows)).reshape(rows, columns)


def _complex(word: str) -> complex:
    re, im = word.strip("()").split(",")
    return complex(float(re), float(im))


def _complex_full(lines: _Lines) -> Entry:
    shape = lines.size()
    if len(shape) != 2:
        return Unread(phrase("an array of {count} dimensions", count=len(shape)))
    return np.array([[_complex(word) for word in lines.take().split()] for _ in range(shape[0])], dtype=complex).reshape(shape)


def _scalar(lines: _Lines) -> Entry:
    return np.array([[float(lines.take())]])


def _diagonal(lines: _Lines) -> Entry:
    rows, columns = lines.size()
    if max(rows, columns) > MAX_STATES:
        return Unread(phrase("a matrix of more than {most}×{most}", most=MAX_STATES))
    full = np.zeros((rows, columns))
    for i in range(min(rows, columns)):
        full[i, i] = float(lines.take())
    return full


def _sparse(lines: _Lines) -> Entry:
    count = int(lines.header("nnz"))
    rows, columns = lines.size()
    if max(rows, columns) > MAX_STATES:
        return Unread(phrase("a sparse matrix of more than {most}×{most}", most=MAX_STATES))
    full = np.zeros((rows, columns))
    for i, j, value in lines.numbers(count):
        if not (1 <= i <= rows and 1 <= j <= columns):
            raise ValueError(i, j)
        full[int(i) - 1, int(j) - 1] += value
    return full


def _text(lines: _Lines) -> Entry:
    words = []
    for _ in range(int(lines.header("elements"))):
        lines.header("length")
        words.append(lines.take())
    return "\n".join(words)


def _range(lines: _Lines) -> Entry:
    lines.take()
    base, limit, step = (float(word) for word in lines.take().split())
    count = int(np.floor((limit - base) / step + 1e-9)) + 1 if step else 0
    if count > 10**6:
        return Unread(phrase("a range"))
    return (base + step * np.arange(max(count, 0)))[None, :]


_READERS: MappingProxyType[str, Callable[[_Lines], Entry]] = MappingProxyType({
    **{f"{kind}matrix": _full for kind in ("", "float ", "bool ", *(f"{kind} " for kind in _WHOLE))},
    **{kind: _scalar for kind in ("scalar", "float scalar", "bool", *(f"{kind} scalar" for kind in _WHOLE))},
    "complex matrix": _complex_full, "complex scalar": lambda lines: np.array([[_complex(lines.take())]]),
    "diagonal matrix": _diagonal, "sparse matrix": _sparse, "sparse bool matrix": _sparse, "string": _text, "sq_string": _text,
    "range": _range, "double_range": _range})


def _variable(lines: _Lines, depth: int) -> Entry:
    kind = lines.header("type")
    if kind in _READERS:
        return _READERS[kind](lines)
    if kind in ("scalar struct", "cell") and depth < _DEEPEST:
        return _members(lines, kind, depth)
    if "complex" in kind:
        return Unread(phrase("complex"))
    return Unread(OBJECT if kind in ("object", "class") else phrase("of a kind that is not known"))


def _members(lines: _Lines, kind: str, depth: int) -> Entry:
    """The fields of a struct by name, or the members of a cell array in their order."""
    shape = lines.size()
    count = int(lines.header("length")) if kind != "cell" else int(np.prod(shape))
    if count > _MOST_PARTS:
        raise ValueError(count)
    fields = [(lines.next_name() or "", _variable(lines, depth + 1)) for _ in range(count)]
    if kind != "cell":
        return dict(fields)
    rows, columns = shape
    return [[fields[i + j * rows][1] for j in range(columns)] for i in range(rows)]
