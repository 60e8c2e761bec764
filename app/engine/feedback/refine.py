"""Refine the peaks and zeros of a response between the points of its grid."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

__all__ = ["Response", "highest", "zeros_of"]

REFINED = 3  # highest grid points around which a peak is looked for
INTERVAL_SHARES = np.linspace(0.0, 1.0, 17)  # how an interval is divided at each round of a search
PEAK_ROUNDS, ROOT_ROUNDS = 7, 12
Response = Callable[[np.ndarray], np.ndarray]


def highest(omega: np.ndarray, values: np.ndarray, at: Response) -> tuple[float, float]:
    """The largest value and where, refined between the neighbours of the highest local maxima of the grid."""
    best = int(np.argmax(values))
    top, where = float(values[best]), float(omega[best])
    inside = np.arange(1, len(omega) - 1)
    summit = inside[(values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:]) & np.isfinite(omega[2:])]
    summit = summit[np.argsort(values[summit])[::-1][:REFINED]]
    if not summit.size:
        return top, where
    low, high = omega[summit - 1], omega[summit + 1]
    for _ in range(PEAK_ROUNDS):
        points = low[:, None] + (high - low)[:, None] * INTERVAL_SHARES
        found = at(points)
        row, column = np.unravel_index(int(np.argmax(found)), found.shape)
        if found[row, column] > top:
            top, where = float(found[row, column]), float(points[row, column])
        k = np.clip(found.argmax(axis=1), 1, len(INTERVAL_SHARES) - 2)
        rows = np.arange(len(k))
        low, high = points[rows, k - 1], points[rows, k + 1]
    return top, where


def zeros_of(omega: np.ndarray, values: np.ndarray, function: Response) -> np.ndarray:
    """Zeros of a function at grid points above 0 or between neighbours of opposite sign, ∞ left out."""
    finite = np.isfinite(omega)
    w, v = omega[finite], values[finite]
    exact = w[(v == 0) & (w > 0)]
    k = np.nonzero(v[:-1] * v[1:] < 0)[0]
    if not k.size:
        return exact
    low, high, sign = w[k], w[k + 1], np.sign(v[k])
    rows = np.arange(len(k))
    for _ in range(ROOT_ROUNDS):
        points = low[:, None] + (high - low)[:, None] * INTERVAL_SHARES[1:-1]
        same = np.sign(function(points)) == sign[:, None]
        before = np.logical_and.accumulate(same, axis=1).sum(axis=1)
        grid = np.concatenate([low[:, None], points, high[:, None]], axis=1)
        low, high = grid[rows, before], grid[rows, before + 1]
    return np.concatenate([exact, (low + high) / 2])
