"""Minimise a function with kinks that is infinite outside its feasible set."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from ..systems.balance import MIN_RATE

__all__ = ["kinked_line", "kinked_minimum", "spaced"]

Objective = Callable[[np.ndarray], float]
Sampler = Callable[[np.random.Generator], np.ndarray]
GRID_POINTS = 161
VALLEYS = 3


def spaced(low: float, high: float, count: int) -> np.ndarray:
    """`count` numbers from low to high, geometric where both have one sign, else even."""
    if low * high > 0 and low != high:
        return np.sign(low) * np.geomspace(abs(low), abs(high), count)
    return np.linspace(low, high, count)


def kinked_line(f: Objective, low: float, high: float) -> tuple[np.ndarray, float]:
    """Global minimum of f over [low, high] as (argument (1,), value): a grid, then Brent in its lowest valleys.

    A kink is met to about 1e-8 relative; the value is inf where nothing on the grid is feasible.
    """
    grid = spaced(low, high, GRID_POINTS)
    values = np.array([f(np.array([s])) for s in grid])
    best, at = float(values.min()), float(grid[int(values.argmin())])
    inner = [k for k in range(GRID_POINTS) if np.isfinite(values[k]) and values[k] <= values[max(k - 1, 0)]
             and values[k] <= values[min(k + 1, GRID_POINTS - 1)]]
    for k in sorted(inner, key=lambda k: values[k])[:VALLEYS]:
        bracket = sorted((grid[max(k - 1, 0)], grid[min(k + 1, GRID_POINTS - 1)]))
        found: Any = minimize_scalar(lambda s: f(np.array([s])), bounds=bracket, method="bounded",
                                options={"xatol": 1e-11 * max(abs(bracket[0]), abs(bracket[1]), MIN_RATE), "maxiter": 200})
        if found.fun < best:
            best, at = float(found.fun), float(found.x)
    return np.array([at]), best


def kinked_minimum(f: Objective, sample: Sampler, seed: int, samples: int, starts: int,
                   evaluations: int, restarts: int) -> Iterator[tuple[float, np.ndarray | None, float]]:
    """Yield (fraction done, best argument so far or None, its value): samples, then Nelder–Mead with restarts.

    Every simplex starts anew at its own result until that no longer helps, since a kink can flatten a simplex.
    """
    rng = np.random.default_rng(seed)
    tried = [sample(rng) for _ in range(samples)]
    values = np.array([f(x) for x in tried])
    order = np.argsort(values, kind="stable")[:starts]
    chosen = [k for k in order if np.isfinite(values[k])]
    if not chosen:
        yield 1.0, None, np.inf
        return
    best, at = float(values[chosen[0]]), tried[chosen[0]]
    yield 0.2, at, best
    for j, k in enumerate(chosen):
        x, value = tried[k], float(values[k])
        for restart in range(restarts):
            x_new, new = _simplex(f, x, 0.2 * 0.35**restart, evaluations)
            gained, x, value = value - new, x_new, new
            if value < best:
                best, at = value, x
            yield 0.2 + 0.8 * (j + (restart + 1) / restarts) / len(chosen), at, best
            if restart > 1 and not gained > 1e-10 * abs(value):
                break
    yield 1.0, at, best


def _simplex(f: Objective, x: np.ndarray, spread: float, evaluations: int) -> tuple[np.ndarray, float]:
    corners = np.vstack([x, x + spread * np.diag(np.where(x != 0, np.abs(x), 1.0))])
    with np.errstate(invalid="ignore"):  # inf − inf where corners are not feasible
        found = minimize(f, x, method="Nelder-Mead", options={
            "initial_simplex": corners, "xatol": 1e-10, "fatol": 1e-12, "maxfev": evaluations, "adaptive": x.size > 4})
    return np.asarray(found.x), float(found.fun)
