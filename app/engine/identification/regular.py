"""Bring a record to a regular step, take its level or trend out, and cut it in two parts."""

from __future__ import annotations

import math

import numpy as np

from ..systems.errors import EngineError, phrase
from ..systems.gates.argument_checks import SECONDS, choice, instance, number, optional, takes
from ..systems.records import record as a_record
from .records import MAX_ROWS, Record

__all__ = ["Trend", "detrend", "resample", "split_record", "trend_of"]

ON_GRID = 0.01  # of a step: how far the rows of a record with missing rows may lie from a regular grid
GAP = 3.5  # steps: where two rows lie farther apart, the outputs between them are missing
TAPS = 10  # of the low-pass filter, for each side, in steps of the coarser grid
CUT_OFF = 0.8  # of half the new sampling rate


@a_record()
class Trend:
    """Levels (and slopes) of all columns: y ≈ level + slope (t − t₀); slopes are zero for a constant."""

    start: float
    u_level: np.ndarray
    u_slope: np.ndarray
    y_level: np.ndarray
    y_slope: np.ndarray


@takes(record=instance(Record), step=optional(SECONDS))
def resample(record: Record, *, step: float | None = None) -> Record:
    """The record at t₀ + k·step. Step in s, the median of its own steps by default.

    Inputs are held between rows, as a digital controller applies them; outputs are interpolated linearly, and missing (NaN) in gaps of
    more than 3.5 steps. For a coarser step both go through the same low-pass filter first, which leaves a linear plant between them
    the same. What was done is added to `notes`. Raises EngineError for more rows than a record may have.
    """
    own = float(np.median(np.diff(record.t)))
    step = own if step is None else step
    if record.dt and abs(step - own) <= 1e-9 * own:
        return record
    span = float(record.t[-1] - record.t[0])
    if not step < span / 8:
        raise EngineError("A step of {step:g} s leaves fewer than 8 rows of {span:g} s; choose a smaller one.", step=step, span=span)
    factor = max(1, math.ceil(step / own - 1e-6))
    fine = step / factor if step > own else step  # a whole number of these makes the step asked for
    if span / fine > MAX_ROWS:
        raise EngineError("At a step of {step:.3g} s this record would have more than {most} rows; choose a larger step.",
                          step=fine, most=MAX_ROWS)
    regular = record if record.dt and abs(fine - own) <= 1e-9 * own else _on_grid(record, fine, own)
    if factor <= 1:
        return regular
    return _thinned(regular, factor)


def _on_grid(record: Record, step: float, own: float) -> Record:
    """Inputs held, outputs interpolated, NaN in gaps."""
    first = record.t[0]
    place = np.round((record.t - first) / step).astype(int)
    if np.abs(record.t - first - step * place).max() <= ON_GRID * step and np.diff(place).min() > 0:
        return _placed(record, first + step * np.arange(place[-1] + 1), place)
    t = first + step * np.arange(math.floor((record.t[-1] - first) / step + 1e-6) + 1)
    before = np.searchsorted(record.t, t + 1e-6 * step, side="right") - 1
    y = np.empty((len(t), record.y.shape[1]))
    lost = 0
    for j, column in enumerate(record.y.T):
        seen = np.isfinite(column)
        y[:, j] = np.interp(t, record.t[seen], column[seen])
        times = record.t[seen]
        left = np.clip(np.searchsorted(times, t + 1e-6 * step, side="right") - 1, 0, len(times) - 1)
        right = np.clip(left + 1, 0, len(times) - 1)
        inside = np.abs(t - times[left]) > 1e-6 * step
        hole = (inside & (times[right] - times[left] > GAP * own)) | (t < times[0] - 1e-6 * step) | (t > times[-1] + 1e-6 * step)
        y[hole, j] = np.nan
        lost += int(hole.sum())
    notes = [phrase("The rows came at irregular times; they were brought to a step of {step:.4g} s.", step=step)]
    if lost:
        notes.append(phrase("Gaps in the record: {count} output values are missing and were not invented.", count=lost))
    return record.noted(*notes, t=t, u=record.u[before], y=y)


def _placed(record: Record, t: np.ndarray, place: np.ndarray) -> Record:
    """The rows where they are on a grid, inputs held and outputs missing in the rows between."""
    y = np.full((len(t), record.y.shape[1]), np.nan)
    y[place] = record.y
    before = np.searchsorted(place, np.arange(len(t)), side="right") - 1
    note = phrase("Rows that are missing: {count}. Their outputs stay missing, their inputs keep the last value.",
                  count=len(t) - len(place))
    return record.noted(note, t=t, u=record.u[before], y=y)


def _thinned(record: Record, factor: int) -> Record:
    """Every `factor`-th row of both, behind a linear-phase low-pass filter."""
    from scipy.signal import firwin, oaconvolve  # late: it brings all of scipy.stats, 0.6 s

    taps = firwin(2 * TAPS * factor + 1, CUT_OFF / factor)
    edge = TAPS * factor

    def slow(columns: np.ndarray) -> np.ndarray:
        wide = np.pad(columns, ((edge, edge), (0, 0)), mode="edge")
        return oaconvolve(wide, taps[:, None], mode="valid", axes=0)[::factor]
    if not np.isfinite(record.y).all():
        raise EngineError("A record with gaps cannot be brought to a coarser step; cut it into pieces without gaps first.")
    note = phrase("Every {factor}th row was kept, behind a low-pass filter: the step is now {step:.4g} s.",
                  factor=factor, step=factor * record.dt)
    u = slow(record.u) if record.u.shape[1] else record.u[::factor]
    return record.noted(note, t=record.t[::factor], u=u, y=slow(record.y))


@takes(record=instance(Record), degree=choice(0, 1))
def trend_of(record: Record, *, degree: int = 0) -> Trend:
    """The means of all columns (degree 0), or their straight lines by least squares (degree 1); gaps are left out."""
    start, t = float(record.t[0]), record.t - record.t[0]

    def line(column: np.ndarray) -> tuple[float, float]:
        seen = np.isfinite(column)
        if not degree:
            return float(column[seen].mean()), 0.0
        b, a = np.polyfit(t[seen] / t[-1], column[seen], 1)
        return float(a), float(b / t[-1])
    u = np.array([line(column) for column in record.u.T]).reshape(-1, 2)
    y = np.array([line(column) for column in record.y.T]).reshape(-1, 2)
    return Trend(start, u[:, 0], u[:, 1], y[:, 0], y[:, 1])


@takes(record=instance(Record), trend=instance(Trend))
def detrend(record: Record, trend: Trend) -> Record:
    """The record less a trend: that of another part of it, where the part that is judged must not help."""
    away = (record.t - trend.start)[:, None]
    return record.noted(u=record.u - trend.u_level - away * trend.u_slope, y=record.y - trend.y_level - away * trend.y_slope)


@takes(record=instance(Record), share=number(0.01, 0.99))
def split_record(record: Record, *, share: float = 0.5) -> tuple[Record, Record]:
    """The first part, to fit with, and the rest, to judge by. Raises EngineError where one would be too short."""
    at = round(share * record.rows)
    if min(at, record.rows - at) < 8:
        raise EngineError(
            "With a share of {share:.2g} fewer than 8 rows are left on one side; choose a share nearer to a half.", share=share
        )
    return record.part(0, at), record.part(at, record.rows)
