"""Prepare a record for the fit: dead time, outliers, slow outputs."""

from __future__ import annotations

import numpy as np

from ..systems.errors import EngineError, phrase
from .probe import dead_time
from .records import Record

__all__ = ["delayed", "slow_outputs", "without_outliers"]

OF_ORDER = 3  # rows without an answer that belong to the order of a plant and not to a dead time
MOST_NAMED = 5  # rows of outliers that are named
FEWEST = 0.9  # of the rows of a slow output that must have come
ROWS_LEFT = 16


def delayed(record: Record, share: float, delay: int | None) -> tuple[Record, int]:
    """The record with its inputs moved down by a dead time in rows, and that time; None estimates it from the first `share`.

    The first rows, whose inputs lie before the record, are left out. Raises EngineError for a dead time longer than the record.
    """
    if delay is None:
        at = max(round(share * record.rows), ROWS_LEFT)
        seen = np.isfinite(record.y[:at]).any(axis=0).all()
        found = dead_time(record.u[:at], record.y[:at]) if seen else 0
        delay = max(found - OF_ORDER + 1, 0) if found > OF_ORDER else 0
        if delay:
            record = record.noted(phrase("The outputs answer late: a dead time of {rows} rows ({time:.3g} s) was taken into account.",
                                         rows=delay, time=delay * record.dt))
    if not delay:
        return record, 0
    if delay > record.rows - ROWS_LEFT:
        raise EngineError("A dead time of {rows} rows leaves too little of a record of {count} rows.", rows=delay, count=record.rows)
    return record.noted(t=record.t[delay:], u=record.u[:-delay], y=record.y[delay:]), delay


def without_outliers(record: Record, marked: np.ndarray) -> Record:
    """The record with marked measurements missing, and a note that names them."""
    if not marked.any():
        return record
    rows = np.flatnonzero(marked.any(axis=1))
    named = ", ".join(f"{record.t[k]:.6g}" for k in rows[:MOST_NAMED]) + (", …" if len(rows) > MOST_NAMED else "")
    note = phrase("Outliers that were set aside, more than five robust deviations from their prediction: {count}, at t = {times} s.",
                  count=int(marked.sum()), times=named)
    return record.noted(note, y=np.where(marked, np.nan, record.y))


def slow_outputs(record: Record) -> Record:
    """The record at the step of its outputs where all come at every r-th row alone, r > 1; inputs become their mean over it."""
    seen = np.isfinite(record.y).all(axis=1)
    rows = np.flatnonzero(seen)
    if len(rows) < ROWS_LEFT or np.isfinite(record.y).any(axis=1).sum() != len(rows):
        return record
    ratio = int(np.median(np.diff(rows)))
    if ratio < 2 or np.any((rows - rows[0]) % ratio) or len(rows) < FEWEST * ((rows[-1] - rows[0]) // ratio + 1):
        return record
    kept = np.arange(rows[0], rows[-1] + 1, ratio)
    u = np.array([record.u[a:a + ratio].mean(axis=0) for a in kept])
    note = phrase("The outputs come at every {ratio}th row: the model has their step, {step:.4g} s, and means of the inputs.",
                  ratio=ratio, step=ratio * record.dt)
    return record.noted(note, t=record.t[kept], u=u, y=record.y[kept])
