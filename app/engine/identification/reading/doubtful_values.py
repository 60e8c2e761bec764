"""Find values that are probably no measurements: marks for a missing value, and stuck signals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...systems.errors import EngineError, Phrase, phrase

__all__ = ["refuse_marks", "stuck_runs"]

MARKS = frozenset({float(sign * int("9" * digits)) for digits in range(2, 8) for sign in (1, -1)}
                  | {-999.25, -1.0e30, 1.0e30, 1.0e20, -1.0e20, 1e31, -1e31, 9.96921e36, 32767.0, -32768.0, 65535.0, -32767.0, 2147483647.0,
                     -2147483648.0, 4294967295.0, -1e10, 1e10, -8888.0, 8888.0, -99.9, -999.9, -9999.9})
FAR = 5.0  # spans of all other values, from which a mark is no value of the signal
APART = 0.5  # spans of all other values, from which a number that comes OFTEN times as often as each of them is asked about
OFTEN = 1.5
FEWEST = 20  # rows without change that may be a stuck sensor
LONGER = 5  # times the second longest stretch without change
KINDS = 30  # different values that a signal needs, so that standing still means something


def refuse_marks(name: str, values: np.ndarray, lines: np.ndarray, kept: Sequence[float]) -> None:
    """Raise EngineError where a value such as −9999 stands far from all others; one that is in `kept` is a value.

    So does any other number at an end of the signal that comes again and again while hardly one of the others does.
    """
    seen = values[np.isfinite(values)]
    found, counts = np.unique(seen, return_counts=True)
    for k, (value, count) in enumerate(zip(found, counts, strict=True)):
        if float(value) in kept or count == len(seen):
            continue
        if float(value) not in MARKS:
            if k in (0, len(found) - 1) and _stands_apart(found, counts, k):
                raise _question(name, float(value), int(count), values, lines)
            continue
        rest = seen[seen != value]
        others = rest[~np.isin(rest, list(MARKS))] if np.isin(rest, list(MARKS)).mean() < 0.5 else rest
        span = float(np.ptp(others)) if len(others) else 0.0
        gap = float(np.abs(others - value).min()) if len(others) else np.inf
        if gap > FAR * max(span, 1e-9 * abs(float(value))):
            raise _question(name, float(value), int(count), values, lines)


def _stands_apart(found: np.ndarray, counts: np.ndarray, k: int) -> bool:
    """Whether the value at an end comes much more often than all others, which are many, and lies apart from them; zero never does."""
    others, often = np.delete(found, k), np.delete(counts, k)
    if found[k] == 0 or len(others) < KINDS or counts[k] < OFTEN * often.max():
        return False
    return bool(np.abs(others - found[k]).min() > APART * np.ptp(others))


def _question(name: str, value: float, count: int, values: np.ndarray, lines: np.ndarray) -> EngineError:
    """The question what a value means."""
    row = int(lines[np.flatnonzero(values == value)[0]])
    return EngineError("Column {name} holds {value} in {count} rows, the first is row {row}; it is far from all other values. Say "
                       "whether it marks a missing value, as in missing={value}, or is a value, as in missing=none.",
                       name=name, value=f"{value:.10g}", count=count, row=row)


def stuck_runs(name: str, values: np.ndarray, lines: np.ndarray) -> tuple[list[tuple[int, int]], tuple[Phrase, ...]]:
    """Stretches of rows in which a signal that moves elsewhere does not change, and a sentence about each."""
    if len(np.unique(values[np.isfinite(values)])) < KINDS:
        return [], ()
    edges = np.flatnonzero(np.concatenate([[True], np.diff(values) != 0, [True]]))
    lengths = np.diff(edges)
    order = np.sort(lengths)[::-1]
    usual = order[1] if len(order) > 1 else order[0]
    found = [(int(edges[k]), int(edges[k + 1])) for k in np.flatnonzero((lengths >= FEWEST) & (lengths > LONGER * usual))]
    return found, tuple(phrase("{name} does not change from row {first} to row {last}; if the sensor was stuck there, read the file with "
                               "missing=stuck.", name=name, first=int(lines[a]), last=int(lines[b - 1])) for a, b in found)
