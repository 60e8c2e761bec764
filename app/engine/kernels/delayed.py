"""Step a loop with delayed input."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .small_matrices import times

__all__ = ["LateInput", "Reading", "delayed_steps"]


class LateInput(NamedTuple):
    """The input of step j runs straight from begin[j] (m,) to end[j] within h; it comes `lag` steps late."""

    begin: np.ndarray
    end: np.ndarray
    h: float
    lag: int


class Reading(NamedTuple):
    """The input asked for at a state z: F z + r, clipped to low … high."""

    F: np.ndarray
    r: np.ndarray
    low: np.ndarray
    high: np.ndarray


def delayed_steps(states, late, step, push, jumps, reading, far, k, stop):
    """Fill states (steps + 1, N) after k, a whole number of `lag`, up to `stop`; the last one that stays below `far`.

    w = (z, begin, slope), z⁺ = stepᵀ w + push + jumps, which fills begin[j + lag] and end[j + lag] with what `reading` asks for at the
    two ends. What rides along must stay below `far` too.
    """
    begin, end, h, lag = late.begin, late.end, late.h, late.lag
    read, r, low, high = reading.F, reading.r, reading.low, reading.high
    N, m = states.shape[1], read.shape[0]
    w, after = np.empty(N + 2 * m), np.empty(N)
    for j in range(k, stop):
        for i in range(N):
            w[i] = states[j, i]
        for i in range(m):
            w[N + i] = begin[j, i]
            w[N + m + i] = (end[j, i] - begin[j, i]) / h
            if j % lag == 0 and not max(abs(w[N + i]), abs(w[N + m + i])) < far:
                return j
        times(step, w, after)
        ahead = (j + 1) % lag != 0 and j + 1 < len(states)
        for i in range(m):
            if ahead and not max(abs(begin[j + 1, i]), abs(end[j + 1, i] - begin[j + 1, i]) / h) < far:
                return j
        for i in range(m):
            a = b = r[j, i]
            for l in range(N):
                a += read[i, l] * w[l]
                b += read[i, l] * (after[l] + push[j, l])
            begin[j + lag, i] = min(max(a, low[i]), high[i])
            end[j + lag, i] = min(max(b, low[i]), high[i])
        for i in range(N):
            a = after[i] + push[j, i] + jumps[j, i]
            if not abs(a) < far:
                return j
            states[j + 1, i] = a
    return stop
