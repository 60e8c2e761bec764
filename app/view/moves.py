"""Where everything on the stage stands at one moment, as plain numbers: what two moments differ in is all that is sent."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

Value = tuple[float, ...]
Frame = dict[tuple[str, str], Value]  # (name of a node, what of it) → numbers, in the order in which nodes were built
KINDS = ("position", "wxyz", "scale", "color", "points")
FINE = 100_000  # parts of a stage unit that a page is told


def changed(before: Frame, after: Frame) -> Frame:
    """What of a frame is not as it was."""
    return {place: value for place, value in after.items() if before.get(place) != value}


def flat(pairs: Iterable[Sequence[Sequence[float]]]) -> Value:
    """Start and end points of segments, one after another."""
    return tuple(number for pair in pairs for point in pair for number in point)


def wire(kind: str, value: Value) -> Any:
    """A value as viser takes it."""
    return np.array(value, np.float32).reshape(-1, 2, 3) if kind == "points" else value


def packed(frame: Frame, names: dict[str, int]) -> str:
    """A frame as `play.js` reads it: for each value the number of its node, of its kind, how many numbers it has, and these.

    `names` gives nodes their numbers; new ones get the next.
    """
    out: list[int] = []
    for (name, kind), value in frame.items():
        times = 1 if kind == "color" else FINE
        out += (names.setdefault(name, len(names)), KINDS.index(kind), len(value))
        out += [round(times * number) for number in value]
    return json.dumps(out, separators=(",", ":"))
