"""Step a sampled loop with clipping and rounding, or with friction in its guides."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .small_matrices import times

__all__ = ["Actuators", "Rubbing", "friction_steps", "sampled_steps"]


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


class Actuators(NamedTuple):
    """s (m,) = asked w + direct, clipped to ±limit, or without rows of `asked`; it acts by enter s."""

    asked: np.ndarray
    direct: np.ndarray
    enter: np.ndarray
    limit: float


class Rubbing(NamedTuple):
    """Forces f (g,), each at most `most`, bring the sliding rows w to zero and act by push f; share = rows push (g×g)."""

    rows: np.ndarray
    push: np.ndarray
    share: np.ndarray
    most: float
    sweeps: int
    exact: float


def friction_steps(w, forces, step, driven, actuators, rubbing, far):
    """Fill w (n_t, N) and forces (n_t, g) from w[0] on: w⁺ = stepᵀ w + driven + enter s + push f; the samples that stay below `far`.

    `step` may have more columns. The forces are found by Gauss and Seidel's sweeps until none moves by more than `exact`; those of the
    sample before are the first guess.
    """
    asked, direct, enter, limit = actuators.asked, actuators.direct, actuators.enter, actuators.limit
    rows, push, share, most = rubbing.rows, rubbing.push, rubbing.share, rubbing.most
    N, g, m = w.shape[1], len(rows), len(asked)
    after, sliding, f = np.empty(step.shape[1]), np.empty(g), np.zeros(g)
    for k in range(len(w) - 1):
        times(step, w[k], after)
        for i in range(N):
            after[i] += driven[k, i]
        for j in range(m):
            s = direct[k, j]
            for i in range(N):
                s += asked[j, i] * w[k, i]
            s = limit if s > limit else -limit if s < -limit else s
            for i in range(N):
                after[i] += enter[i, j] * s
        for l in range(g):
            a = 0.0
            for i in range(N):
                a += rows[l, i] * after[i]
            sliding[l] = a
        for _ in range(rubbing.sweeps):
            moved = 0.0
            for l in range(g):
                new = sliding[l]
                for j in range(g):
                    new += share[l, j] * f[j]
                new = f[l] - new / share[l, l]
                new = most if new > most else -most if new < -most else new
                moved = max(moved, abs(new - f[l]))
                f[l] = new
            if moved <= rubbing.exact:
                break
        for i in range(N):
            a = after[i]
            for l in range(g):
                a += push[i, l] * f[l]
            if not abs(a) < far:
                return k + 1
            w[k + 1, i] = a
        for l in range(g):
            forces[k + 1, l] = f[l]
    return len(w)
