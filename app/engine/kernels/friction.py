"""Step a sampled loop with friction in its guides."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .small_matrices import times

__all__ = ["Actuators", "Rubbing", "friction_steps"]


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
