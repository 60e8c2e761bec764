"""Bring channels with clocks of their own to the clock of the first output."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...systems.errors import EngineError
from .tables import ArrayTable, Heading

__all__ = ["Channel", "channel_table", "default_channels"]

CLOCK = "time"
NAMED = re.compile(r"(?:.*[./])?(?P<kind>[uUyY])_?\d*")
LISTED = 200


@dataclass(frozen=True, eq=False)
class Channel:
    """Times in s and values of one signal, with its unit."""

    times: np.ndarray
    values: np.ndarray
    unit: str = ""


def default_channels(there: Sequence[str], inputs: Sequence[str], outputs: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The inputs and outputs that were asked for, else those called u… and y…. Raises EngineError where there is no such channel."""
    listed = ", ".join(there)[:LISTED]
    if not inputs and not outputs:
        kinds = {name: found["kind"].lower() for name in there if (found := NAMED.fullmatch(name))}
        inputs = tuple(name for name, kind in kinds.items() if kind == "u")
        outputs = tuple(name for name, kind in kinds.items() if kind == "y")
    for name in (*inputs, *outputs):
        if name not in there:
            raise EngineError("There is no column {name}; the file has {columns}.", name=name, columns=listed)
    if not outputs:
        raise EngineError("No column is an output y; the file has {columns}: say which ones are outputs.", columns=listed)
    return tuple(inputs), tuple(outputs)


def channel_table(signals: Mapping[str, Channel], inputs: Sequence[str], outputs: Sequence[str]) -> ArrayTable:
    """All signals at the times of the fastest output: an input keeps its last value, an output is NaN where it has no sample.

    Rows before the first value of an input are left out. Raises EngineError for an output without samples.
    """
    for name in outputs:
        if len(signals[name].times) < 2:
            raise EngineError("An output has no measurement at all; leave it out.")
    t = max((signals[name].times for name in outputs), key=len)
    begin = max((signals[name].times[0] for name in inputs if len(signals[name].times)), default=t[0])
    t = t[t >= begin]
    columns = [t - t[0] if len(t) else t]
    columns += [_at(t, signals[name], name in inputs) for name in (*inputs, *outputs)]
    headings = [Heading(CLOCK, CLOCK, "s", True)]
    headings += [Heading(name, name, signals[name].unit, True) for name in (*inputs, *outputs)]
    return ArrayTable(tuple(headings), tuple(columns))


def _at(t: np.ndarray, channel: Channel, held: bool) -> np.ndarray:
    """Values at the times of the clock: the last one for an input, the one within half a step for an output."""
    times, values = channel.times, channel.values
    if not len(times) or len(t) < 2:
        return np.full(len(t), np.nan)
    half = 0.5 * float(np.median(np.diff(t)))
    if held:
        at = np.searchsorted(times, t + 1e-6 * half, side="right") - 1
        return np.where(at < 0, np.nan, values[np.maximum(at, 0)])
    right = np.clip(np.searchsorted(times, t), 0, len(times) - 1)
    left = np.maximum(right - 1, 0)
    near = np.where(np.abs(times[left] - t) <= np.abs(times[right] - t), left, right)
    return np.where(np.abs(times[near] - t) < half, values[near], np.nan)
