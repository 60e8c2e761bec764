"""Minimise the coupling index of two channels by a simplex."""

from __future__ import annotations

import numpy as np

__all__ = ["decoupling_search_steps", "index_at"]


def index_at(first: np.ndarray, second: np.ndarray, narrow: float, a: float, b: float) -> float:
    """J(a, b) from the quadratics (n_ω, 3) of both rows; ∞ where |1 − ab| < narrow or J is not finite."""
    if abs(1.0 - a * b) < narrow:
        return np.inf
    J = 0.0
    for k in range(len(first)):
        J += ((first[k, 0] * b + first[k, 1]) * b + first[k, 2]) / (first[k, 0] + (first[k, 1] + first[k, 2] * a) * a)
        J += ((second[k, 0] * a + second[k, 1]) * a + second[k, 2]) / (second[k, 0] + (second[k, 1] + second[k, 2] * b) * b)
    return J if abs(J) < np.inf else np.inf


def decoupling_search_steps(first, second, narrow, simplex, near, flat, most):
    """Nelder and Mead's steps on J from a simplex (3, 2), which ends with the best corner first; the number of values taken.

    They end where all corners lie within `near` of the best, and their values within `flat`, or after `most` values.
    """
    f, middle, tried, further = np.empty(3), np.empty(2), np.empty(2), np.empty(2)
    for i in range(3):
        f[i] = index_at(first, second, narrow, simplex[i, 0], simplex[i, 1])
    calls = 3
    while True:
        for i in range(1, 3):  # the best first, equals as they stand
            for j in range(i, 0, -1):
                if f[j] < f[j - 1]:
                    f[j], f[j - 1] = f[j - 1], f[j]
                    for l in range(2):
                        simplex[j, l], simplex[j - 1, l] = simplex[j - 1, l], simplex[j, l]
        there = True
        for i in range(1, 3):
            there = there and abs(f[0] - f[i]) <= flat
            for l in range(2):
                there = there and abs(simplex[i, l] - simplex[0, l]) <= near
        if there or calls >= most:
            return calls
        for l in range(2):
            middle[l] = (simplex[0, l] + simplex[1, l]) / 2
            tried[l] = 2 * middle[l] - simplex[2, l]
        value, shrink = index_at(first, second, narrow, tried[0], tried[1]), False
        calls += 1
        if value < f[0] or not value < f[1]:
            share = -2.0 if value < f[0] else -0.5 if value < f[2] else 0.5
            for l in range(2):
                further[l] = (1 - share) * middle[l] + share * simplex[2, l]
            other = index_at(first, second, narrow, further[0], further[1])
            calls += 1
            if other < min(value, f[2]) or (other == value and f[0] <= value < f[2]):
                value = other
                for l in range(2):
                    tried[l] = further[l]
            else:
                shrink = not value < f[0]
        if shrink:
            for i in range(1, 3):
                for l in range(2):
                    simplex[i, l] = simplex[0, l] + 0.5 * (simplex[i, l] - simplex[0, l])
                f[i] = index_at(first, second, narrow, simplex[i, 0], simplex[i, 1])
                calls += 1
        else:
            f[2] = value
            for l in range(2):
                simplex[2, l] = tried[l]
