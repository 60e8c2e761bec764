"""Step a sampled loop with clipping and rounding."""

from __future__ import annotations

import numpy as np

from .small_matrices import times

__all__ = ["sampled_steps"]


def sampled_steps(now, push, step, direct, limit, rounds, path, clipped, begin, stop):
    """Take runs begin … stop − 1 of now = (w, m, s) (runs, N + p + m) over the samples of push (steps, runs, N + p + m).

    At each sample m is rounded to whole numbers if `rounds`, s + Tᵀm with Tᵀ = `direct` (p, m) clipped to ±limit; path
    (steps, runs, N + p + m) keeps that, clipped (runs,) counts the samples at which s was clipped, and
    now ← stepᵀ now + push (`step` may have more columns).
    """
    width, (p, m) = now.shape[1], direct.shape
    N = width - p - m
    own, after = np.empty(width), np.empty(step.shape[1])
    for run in range(begin, stop):
        for i in range(width):
            own[i] = now[run, i]
        for k in range(push.shape[0]):
            if rounds:
                for i in range(N, N + p):
                    own[i] = np.rint(own[i])
            bent = False
            for i in range(m):
                u = own[N + p + i]
                for j in range(p):
                    u += own[N + j] * direct[j, i]
                if u > limit or u < -limit:
                    bent = True
                    u = limit if u > limit else -limit
                own[N + p + i] = u
            if bent:
                clipped[run] += 1.0
            times(step, own, after)
            for i in range(width):
                path[k, run, i] = own[i]
                own[i] = after[i] + push[k, run, i]
        for i in range(width):
            now[run, i] = own[i]
    return stop
