"""Step a sampled loop with friction in its guides."""

from __future__ import annotations

import numpy as np

from .small_matrices import times

__all__ = ["friction_steps"]


def friction_steps(w, forces, step, driven, asked, direct, enter, limit, rows, push, share, most, sweeps, exact, far):
    """Fill w (n_t, N) and forces (n_t, g) from w[0] on: w⁺ = stepᵀ w + driven + enter s + push f; the samples that stay below `far`.

    s (m,) = asked w + direct, clipped to ±limit, or without rows of `asked`; `step` may have more columns. Each of the forces f, at most
    `most`, brings the sliding rows w⁺ to zero where it can: Gauss and Seidel's sweeps over share = rows push (g×g) until none moves by
    more than `exact`; the forces of the sample before are the first guess.
    """
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
        for _ in range(sweeps):
            moved = 0.0
            for l in range(g):
                new = sliding[l]
                for j in range(g):
                    new += share[l, j] * f[j]
                new = f[l] - new / share[l, l]
                new = most if new > most else -most if new < -most else new
                moved = max(moved, abs(new - f[l]))
                f[l] = new
            if moved <= exact:
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
