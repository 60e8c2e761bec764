"""Pack recorded states into script files that a page can load from a folder, without a server.

A file is one call `observerLabData(name, text)`; its text is base64 of gzip of a line of JSON and the arrays that it names.
Arrays are kept once for all languages and themes of a scene, in single precision, and values once for all themes and widths of a
language. A run is kept as differences of 16-bit numbers in steps that no pixel shows, from the first run of its scene where that is less.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from ..page.record.recorded_screen import RecordedRun
from ..page.viser_private.stage_frames import PROPERTY_KINDS
from .screens import Values

ALIGNMENT = 8  # bytes to which an array begins
TYPES = MappingProxyType({"f": "<f4", "i": "<i4", "u": "<u4", "b": "|u1"})  # kinds of NumPy's numbers → how they are kept
MOST_16_BIT = 32767
# a pixel is 5e-3 stage units
STEPS = MappingProxyType({"position": 5e-4, "wxyz": 1e-4, "scale": 1e-4, "color": 1.0, "points": 5e-4, "text": 1.0})
BELOW = (0.0, 0.0, -9.0)  # a place that nobody sees, for segments that a frame does not have


@dataclass
class Arrays:
    """Arrays of one file, each once."""

    kept: list[np.ndarray] = field(default_factory=list)
    numbers: dict[bytes, int] = field(default_factory=dict)

    def add(self, array: np.ndarray) -> int:
        """The number of an array in this file."""
        if array.dtype.itemsize > 1 and array.dtype.str not in ("<i2",):
            array = array.astype(TYPES[array.dtype.kind])
        key = hashlib.sha256(array.dtype.str.encode() + array.tobytes()).digest()
        if key not in self.numbers:
            self.numbers[key] = len(self.kept)
            self.kept.append(array)
        return self.numbers[key]

    def plain(self, value: Any) -> Any:
        """A value as JSON holds it, with the numbers of its arrays."""
        if isinstance(value, np.ndarray):
            return {"$": self.add(value)}
        if isinstance(value, (bytes, bytearray, memoryview)):
            return {"$": self.add(np.frombuffer(value, np.uint8))}
        if isinstance(value, Mapping):
            return {str(key): self.plain(each) for key, each in value.items()}
        if isinstance(value, (list, tuple)):
            return [self.plain(each) for each in value]
        return value


@dataclass
class Table:
    """Values of one file, each once, as JSON beside the arrays of a scene."""

    arrays: Arrays
    kept: list[Any] = field(default_factory=list)
    numbers: dict[str, int] = field(default_factory=dict)
    _known: dict[int, tuple[Any, int]] = field(default_factory=dict)

    def add(self, value: Any) -> int:
        """The number of a value in this file."""
        known = self._known.get(id(value))
        if known is not None and known[0] is value:
            return known[1]
        plain = self.arrays.plain(value)
        key = json.dumps(plain, ensure_ascii=False)
        if key not in self.numbers:
            self.numbers[key] = len(self.kept)
            self.kept.append(plain)
        self._known[id(value)] = value, self.numbers[key]
        return self.numbers[key]


@dataclass
class Tables:
    """Places and values of all looks of one language, each once."""

    arrays: Arrays = field(default_factory=Arrays)

    def __post_init__(self) -> None:
        self.places, self.values = Table(self.arrays), Table(self.arrays)

    def difference(self, base: Values, now: Values) -> list[list[int]]:
        """Where a state differs from the base: numbers of place and value, −1 for what is gone."""
        out = [[self.places.add(list(place)), -1] for place in base if place not in now]
        for place, value in now.items():
            before = base.get(place, now)
            if before is value:
                continue
            if before is not now and alike(before, value):
                continue
            out.append([self.places.add(list(place)), self.values.add(value)])
        return out

    @property
    def content(self) -> dict[str, list[Any]]:
        """What their file holds."""
        return {"places": self.places.kept, "values": self.values.kept}


def alike(one: Any, other: Any) -> bool:
    """Whether two values are the same."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return isinstance(one, np.ndarray) and isinstance(other, np.ndarray) and one.dtype == other.dtype and np.array_equal(one, other)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(alike(one[key], other[key]) for key in one)
    return type(one) is type(other) and one == other


@dataclass
class Runs:
    """Runs of one scene, each once: their times and, for each value that moves, its numbers at these times."""

    arrays: Arrays
    kept: list[dict[str, Any]] = field(default_factory=list)
    _first: dict[tuple[str, str, tuple[int, ...], float], np.ndarray] = field(default_factory=dict)

    def add(self, run: RecordedRun) -> int:
        """The number of a run."""
        names: list[str] = []
        channels = []
        for name, kind in dict.fromkeys(key for frame in run.frames for key in frame):
            rows = [frame.get((name, kind), ()) for frame in run.frames]
            wide = max(map(len, rows))
            fill = (float(ord(" ")),) * wide if kind == "text" else BELOW * (wide // 3 + 1)
            numbers = np.array([[*row, *fill[:wide - len(row)]] for row in rows], float)
            if len(numbers) > 1 and np.all(numbers == numbers[0]):
                continue
            if name not in names:
                names.append(name)
            step = max(float(np.abs(numbers).max()) / MOST_16_BIT, STEPS[kind])
            deltas = np.diff(np.round(numbers / step).astype(np.int64), axis=0, prepend=0)
            first = self._first.setdefault((name, kind, deltas.shape, step), deltas)
            other = -1
            if 0.0 < _size(deltas - first) < _size(deltas):
                other, deltas = self._whole(first), deltas - first
            channels.append([names.index(name), PROPERTY_KINDS.index(kind), wide, step, self._whole(deltas), other])
        times = self.arrays.add(np.array(run.times, np.float32))
        packed = {"times": times, "count": len(run.times), "names": names, "channels": channels, "end": run.end, "rate": run.rate}
        if packed not in self.kept:
            self.kept.append(packed)
        return self.kept.index(packed)

    def _whole(self, deltas: np.ndarray) -> int:
        """The number of an array of differences, which may wrap as 16-bit numbers do."""
        return self.arrays.add(deltas.astype(np.int16).T.ravel())


def _size(deltas: np.ndarray) -> float:
    """About how many bits differences take."""
    return float(np.log2(1.0 + np.abs(deltas)).sum())


def data_file(name: str, content: Any, arrays: Iterable[np.ndarray] = ()) -> str:
    """The text of a script file."""
    head, blob = [], bytearray()
    for array in arrays:
        blob += bytes(-len(blob) % ALIGNMENT)
        head.append([array.dtype.str, array.size, len(blob)])
        blob += array.tobytes()
    words = json.dumps({"arrays": head, "content": content}, ensure_ascii=False, separators=(",", ":")).encode()
    words += b" " * (-len(words) % ALIGNMENT)
    packed = gzip.compress(len(words).to_bytes(ALIGNMENT, "little") + words + bytes(blob), 9, mtime=0)
    return f'observerLabData({json.dumps(name)},"{base64.b64encode(packed).decode()}")\n'
