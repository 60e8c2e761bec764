"""Probe a record by a long regression before the fit: outliers, dead time, drift, gaps."""

from __future__ import annotations

import numpy as np
from scipy.special import fdtrc

__all__ = ["dead_time", "drifts", "filled", "outliers"]

LAGS = 8  # of outputs and inputs in the regression
SPIKE = 5.0  # robust standard deviations of a residual, from which a value may be an outlier
LONGEST_RUN = 3  # rows in a row that may be outliers; a longer stretch is a change of the plant
MOST = 0.08  # share of rows that may be outliers
PASSES = 12
TO_SIGMA = 1.4826  # from the median absolute deviation of Gaussian values to their standard deviation
MOST_DELAY = 40  # rows
SURE = 1e-6  # p-value from which a lag of the input counts
DRIFT = 1e-6


def filled(y: np.ndarray) -> np.ndarray:
    """Each output with straight lines over its gaps."""
    out = np.array(y)
    rows = np.arange(len(y))
    for column in out.T:
        seen = np.isfinite(column)
        column[~seen] = np.interp(rows[~seen], rows[seen], column[seen])
    return out


def outliers(u: np.ndarray, y: np.ndarray, first: int) -> np.ndarray:
    """Which measurements (N, p) are outliers: their residual is above 5 robust deviations and the largest within 4 rows on each side.

    The residuals are those of a regression over 8 lags that is fitted to the rows before `first`, again and again without the values that
    were found, which the prediction replaces. Stretches of more than 3 rows are no outliers, nor are more than 8 % of all rows.
    """
    N, p = y.shape
    marked = np.zeros((N, p), dtype=bool)
    if first < 4 * (LAGS * (p + u.shape[1]) + 1):
        return marked
    seen, work = np.isfinite(y), filled(y)
    for _ in range(PASSES):
        residual, predicted = _residuals(u, work, first, ~marked.any(axis=1))
        scale = np.maximum(_scale(residual[:first]), _scale(residual[first:]))
        size = np.abs(residual + np.where(marked, y - work, 0.0)) / np.where(scale > 0, scale, np.inf)
        near = np.max([np.roll(size, shift, axis=0) for shift in range(-4, 5)], axis=0)
        found = seen & ~marked & (size > SPIKE) & (size >= near)
        found[:LAGS] = False
        if not found.any():
            break
        marked |= found
        work = np.where(marked, predicted, work)
    for column in marked.T:
        edges = np.flatnonzero(np.diff(np.concatenate([[0], column.astype(int), [0]])))
        for a, b in edges.reshape(-1, 2):
            if b - a > LONGEST_RUN:
                column[a:b] = False
    for part in (slice(0, first), slice(first, N)):
        if marked[part].any(axis=1).mean() > MOST:
            marked[part] = False
    return marked


def _residuals(u: np.ndarray, y: np.ndarray, first: int, good: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residuals and predictions of all rows; the regression takes rows before `first` in two rounds, the second without large ones."""
    table = _table(u, y, range(0, LAGS + 1))
    fit = np.zeros(len(y), dtype=bool)
    fit[LAGS:first] = True
    fit &= good
    residual, predicted = np.zeros_like(y), np.array(y)
    for j in range(y.shape[1]):
        rows = fit
        for _ in range(3):
            found = np.linalg.lstsq(table[rows], y[rows, j], rcond=1e-10)[0]
            all_rows = y[:, j] - table @ found
            scale = _scale(all_rows[fit][:, None])[0]
            rows = fit & (np.abs(all_rows) <= 3 * max(float(scale), 1e-300))
            if rows.sum() < 2 * table.shape[1]:
                break
        residual[LAGS:, j] = all_rows[LAGS:]
        predicted[LAGS:, j] = (table @ found)[LAGS:]
    return residual, predicted


def _scale(values: np.ndarray) -> np.ndarray:
    return TO_SIGMA * np.median(np.abs(values - np.median(values, axis=0)), axis=0)


def _table(u: np.ndarray, y: np.ndarray, lags: range) -> np.ndarray:
    """Lagged outputs (from 1 to 8), inputs at these lags, and a constant."""
    N = len(y)
    columns = [np.ones((N, 1))]
    for lag in range(1, LAGS + 1):
        columns.append(np.vstack([np.zeros((lag, y.shape[1])), y[:N - lag]]))
    columns += [np.vstack([np.zeros((lag, u.shape[1])), u[:N - lag]]) for lag in lags]
    return np.hstack(columns)


def dead_time(u: np.ndarray, y: np.ndarray) -> int:
    """Rows by which the inputs act later than in the next row: lags of the input before the first one that surely counts.

    The regression has 8 lags of the outputs and all lags of the inputs; the lags up to d count where an F test of them beside the later
    ones says so. A plant whose first answer is small has a few such lags without any dead time; they are its order, not this.
    """
    N, m = u.shape
    most = min(MOST_DELAY, N // (4 * max(m, 1)) - LAGS - 2)
    if not m or most < 2:
        return 0
    y = filled(y)
    start = most + LAGS
    base = _table(u, y, range(0))[start:]
    lagged = [np.vstack([np.zeros((lag, m)), u[:N - lag]])[start:] for lag in range(most + LAGS)]
    whole = np.hstack([base, *lagged])
    target = y[start:]
    free = len(target) - whole.shape[1]
    if free < 10:
        return 0
    rest = _rest(whole, target)
    for d in range(1, most + 1):
        fewer = np.hstack([base, *lagged[d + 1:]])
        extra = (d + 1) * m
        ratio = ((_rest(fewer, target) - rest) / extra / np.maximum(rest / free, 1e-300)).max()
        if fdtrc(extra, free, max(float(ratio), 0.0)) < SURE:
            return d - 1
    return 0


def _rest(table: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The sums of squares that a regression leaves, for each output."""
    left = target - table @ np.linalg.lstsq(table, target, rcond=1e-10)[0]
    return (left**2).sum(axis=0)


def drifts(u: np.ndarray, y: np.ndarray) -> bool:
    """Whether a straight line over time explains a part of an output that lags of inputs and outputs do not."""
    y = filled(y)
    table, target = _table(u, y, range(0, LAGS + 1))[LAGS:], y[LAGS:]
    free = len(target) - table.shape[1] - 1
    if free < 10:
        return False
    rest = _rest(np.hstack([table, np.linspace(-1, 1, len(target))[:, None]]), target)
    ratio = ((_rest(table, target) - rest) / np.maximum(rest / free, 1e-300)).max()
    return bool(fdtrc(1, free, max(float(ratio), 0.0)) < DRIFT)
