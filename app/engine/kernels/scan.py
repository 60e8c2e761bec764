"""Step an affine recursion."""

from __future__ import annotations

__all__ = ["scan_steps"]


def scan_steps(step, forcing, states):
    """Fill states (steps + 1, N), whose first row is the start, by z⁺ = stepᵀ z + g with g the rows of forcing (steps, N)."""
    N, whole = len(step), len(step) - len(step) % 4
    for k in range(len(forcing)):
        for i in range(N):
            states[k + 1, i] = forcing[k, i]
        for j in range(0, whole, 4):  # four at once, so that the row is read and written less often
            a, b, c, d = states[k, j], states[k, j + 1], states[k, j + 2], states[k, j + 3]
            for i in range(N):
                states[k + 1, i] += a * step[j, i] + b * step[j + 1, i] + c * step[j + 2, i] + d * step[j + 3, i]
        for j in range(whole, N):
            a = states[k, j]
            for i in range(N):
                states[k + 1, i] += a * step[j, i]
    return len(forcing)
