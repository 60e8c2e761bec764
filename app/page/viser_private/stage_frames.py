"""Compute where everything on the stage stands, and send only what changed between two moments."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from itertools import chain
from typing import Any

import numpy as np

Value = tuple[float, ...]
Frame = dict[tuple[str, str], Value]  # (name of a node, what of it) → numbers, in the order in which nodes were built
PROPERTY_KINDS = ("position", "wxyz", "scale", "color", "points", "text")
WHOLE_NUMBERS = ("color", "text")  # kinds whose values are whole: text is sent as the numbers of its letters
UNITS_PER_STAGE_UNIT = 100_000  # parts of a stage unit that a page is told


def changed_values(before: Frame, after: Frame) -> Frame:
    """What of a frame is not as it was."""
    return {place: value for place, value in after.items() if before.get(place) != value}


def flatten_segments(pairs: Iterable[Sequence[Sequence[float]]]) -> Value:
    """Start and end points of segments, one after another."""
    return tuple(chain.from_iterable(chain.from_iterable(pairs)))


def viser_value(kind: str, value: Value) -> Any:
    """A value as viser takes it."""
    if kind == "text":
        return "".join(chr(int(letter)) for letter in value)
    return np.array(value, np.float32).reshape(-1, 2, 3) if kind == "points" else value


def letters_of(words: str) -> Value:
    """Words as a value of a frame."""
    return tuple(float(ord(letter)) for letter in words)


def pack_frame(frame: Frame, names: dict[str, int]) -> str:
    """A frame as `play.js` reads it: for each value the number of its node, of its kind, how many numbers it has, and these.

    `names` gives nodes their numbers; new ones get the next.
    """
    out: list[int] = []
    for (name, kind), value in frame.items():
        times = 1 if kind in WHOLE_NUMBERS else UNITS_PER_STAGE_UNIT
        out += (names.setdefault(name, len(names)), PROPERTY_KINDS.index(kind), len(value))
        out += [round(times * number) for number in value]
    return json.dumps(out, separators=(",", ":"))
