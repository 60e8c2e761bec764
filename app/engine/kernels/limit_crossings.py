"""Find where an input leaves its limits along a Taylor series."""

from __future__ import annotations

import numpy as np

from .small_matrices import times

__all__ = ["first_exit", "piece"]

MAX_NEWTON_STEPS = 80
CROSSING_SAMPLES = 8  # of a polynomial, between which it crosses a limit at most once


def piece(w, part, left, F, within, rate, taylor, short, v, ud, change, line):
    """Move w along its Taylor series for `part`, or until an input leaves its limits; the time that it took."""
    m, N = F.shape
    terms = line.shape[0]
    times(rate, w, v)
    times(taylor, v[:N], change)
    for i in range(m):
        line[0, i] = ud[i]
        for k in range(1, terms):
            a = 0.0
            for j in range(N):
                a += change[(k - 1) * N + j] * F[i, j]
            line[k, i] = a
    end = part / short
    leave = end
    for i in range(m):
        for side in range(2):
            if np.isfinite(within[side, i]):
                leave = min(leave, first_exit(line, i, within[side, i], 1.0 if side else -1.0, end))
    power = 1.0
    for k in range(terms - 1):
        power *= leave
        for j in range(N):
            w[j] += power * change[k * N + j]
    return left if leave * short >= left * (1 - 1e-14) else leave * short


def first_exit(line, i, limit, side, end):
    """The first s in (0, end] where side·(polynomial i − limit) turns positive, by Newton within a bracket; or end."""
    terms = line.shape[0]
    a = b = 0.0
    found = False
    for j in range(1, CROSSING_SAMPLES + 1):
        b = end * j / CROSSING_SAMPLES
        value = 0.0
        for k in range(terms - 1, -1, -1):
            value = value * b + line[k, i]
        if side * (value - limit) > 0:
            found = True
            break
        a = b
    if not found:
        return end
    s = 0.5 * (a + b)
    for _ in range(MAX_NEWTON_STEPS):
        value = slope = 0.0
        for k in range(terms - 1, -1, -1):
            slope = slope * s + value
            value = value * s + line[k, i]
        value -= limit
        if value == 0:
            break
        if side * value > 0:
            b = s
        else:
            a = s
        new = s - value / slope if slope != 0 else a
        if not a < new < b:
            new = 0.5 * (a + b)
        done = abs(new - s) <= 1e-15 * abs(b) + 1e-300
        s = new
        if done:
            break
    return s
