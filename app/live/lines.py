"""Read lines of a device: time, inputs, readings, with names and a checksum where they are given."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

__all__ = ["LineError", "LineReader", "Sample", "with_checksum"]

LONGEST_LINE = 1000  # bytes of a line; a longer one is left out up to its end
LARGEST = 1e12  # of a value; one beyond it counts as missing
NAME = re.compile(r"([uy]):(\w{1,30})", re.ASCII)


class LineError(ValueError):
    """A line that cannot be used; the message says why, and counts under its first words."""


@dataclass(frozen=True, eq=False)
class Sample:
    """One line: time in s, inputs u (m,), readings y (p,), NaN where one is missing."""

    t: float
    u: np.ndarray
    y: np.ndarray


def with_checksum(line: str) -> str:
    """The line with the exclusive or of its bytes behind a star, as two hexadecimal digits."""
    value = 0
    for byte in line.encode():
        value ^= byte
    return f"{line}*{value:02X}"


@dataclass
class LineReader:
    """Cuts bytes into lines and lines into samples of m inputs and p readings; what is wrong is counted in `refused`, never raised.

    A line is `t,u…,y…`. A header `# t,u:NAME,…,y:NAME,…` gives another order of the columns. `*HH` behind a line is its checksum.
    """

    inputs: tuple[str, ...]
    readings: tuple[str, ...]
    checked: bool = False  # whether a line without a checksum is refused
    refused: dict[str, int] = field(default_factory=dict)
    taken: int = 0
    _rest: bytes = b""
    _skipping: bool = False
    _order: list[int] | None = None

    def feed(self, data: bytes) -> Iterator[Sample]:
        """The samples of the lines that are complete now."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            if self._skipping:
                self._skipping = False
                continue
            yield from self._samples(line)
        if len(self._rest) > LONGEST_LINE:
            if not self._skipping:
                self._refuse("too long")
            self._rest, self._skipping = b"", True

    def _samples(self, line: bytes) -> Iterator[Sample]:
        try:
            sample = self.read(line)
        except LineError as problem:
            self._refuse(str(problem))
            return
        if sample is not None:
            self.taken += 1
            yield sample

    def _refuse(self, why: str) -> None:
        self.refused[why] = self.refused.get(why, 0) + 1

    def read(self, line: bytes) -> Sample | None:
        """The sample of a line, None for a header, a comment or nothing. Raises LineError."""
        if len(line) > LONGEST_LINE:
            raise LineError("too long")
        try:
            words = line.decode("ascii").strip()
        except UnicodeDecodeError:
            raise LineError("not ASCII") from None
        if not words:
            return None
        words = self._without_checksum(words)
        if words.startswith("#"):
            self._take_header(words[1:])
            return None
        cells = words.split(",")
        if len(cells) != 1 + len(self.inputs) + len(self.readings):
            raise LineError("wrong number of values")
        values = [_value(cell) for cell in cells]
        if not abs(values[0]) <= LARGEST:
            raise LineError("no time")
        rest = values[1:] if self._order is None else [values[1 + k] for k in self._order]
        u = np.array(rest[:len(self.inputs)])
        if np.isnan(u).any():
            raise LineError("an input is missing")
        return Sample(values[0], u, np.array(rest[len(self.inputs):]))

    def _without_checksum(self, words: str) -> str:
        body, star, digits = words.rpartition("*")
        if not star:
            if self.checked and not words.startswith("#"):
                raise LineError("no checksum")
            return words
        if with_checksum(body) != f"{body}*{digits.upper()}":
            raise LineError("wrong checksum")
        return body

    def _take_header(self, words: str) -> None:
        """A header that names every column of the design gives their order; any other comment is left alone."""
        cells = [cell.strip() for cell in words.split(",")]
        if len(cells) != 1 + len(self.inputs) + len(self.readings) or cells[0] != "t":
            return
        wanted = [*(f"u:{name}" for name in self.inputs), *(f"y:{name}" for name in self.readings)]
        if not all(NAME.fullmatch(cell) for cell in cells[1:]) or sorted(cells[1:]) != sorted(wanted):
            raise LineError("header names other signals")
        self._order = [cells[1:].index(name) for name in wanted]


def _value(cell: str) -> float:
    cell = cell.strip()
    if cell in ("", "nan", "NaN"):
        return float("nan")
    if not re.fullmatch(r"[+-]?(\d{1,20}(\.\d{0,30})?|\.\d{1,30})([eE][+-]?\d{1,3})?", cell, re.ASCII):
        raise LineError("not a number")
    value = float(cell)
    return value if abs(value) <= LARGEST else float("nan")
