"""Compute values and derivatives of maps of the state, many states at a time."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from .errors import EngineError, ShapeError
from .gates.argument_checks import FUNCTION, NAME, array, count, optional, takes
from .gates.map_roles import adapted

__all__ = ["each_column", "slopes", "values_of"]

Map = Callable[[np.ndarray, np.ndarray], np.ndarray]
COMPLEX_STEP = 1e-30  # of the complex step: its square is below every rounding
CENTRAL_STEP = 6e-6  # of the size of a state: ε^(1/3), where a difference loses as much to rounding as to curvature
ALIKE = 1e-4  # of the larger slope: how far the complex step may lie from a difference
PLACES = ((0.0, 0.0), (0.7, 0.3), (-0.7, 0.3), (0.4, -0.6))  # in deviations: odd and even states of the points looked at


@takes(one=FUNCTION)
def each_column(one: Map) -> Map:
    """A map of columns, x (n, N) and u (m, 1), from a function of one state x (n,) and input u (m,).

    >>> each_column(lambda x, u: [x[0] * x[1]])(np.array([[1, 2], [3, 4]]), np.zeros((1, 1)))
    array([[3, 8]])
    """
    call = adapted(one)

    def many(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.stack([np.asarray(call(column, u[:, 0])) for column in x.T], axis=1)

    return many


def values_of(f: Map, x: np.ndarray, u: np.ndarray, name: str, rows: int | None = None) -> np.ndarray:
    """f at the states in the columns of x (n, N): (rows, N). Raises ShapeError with `name` in it."""
    values = np.asarray(f(x, u))
    if values.ndim != 2 or values.shape != (rows or len(values), x.shape[1]):
        if rows is None:
            raise ShapeError("The map must return a column for each of {n} states; its result has the shape "
                             "{values_shape}.", n=x.shape[1], values_shape=values.shape)
        raise ShapeError("{name} must return {rows} rows and a column for each state. For {columns} states its result has the shape "
                         "{values_shape}; each_column wraps a function of one state.",
                         name=name, rows=rows, columns=x.shape[1], values_shape=values.shape)
    return values


@takes(f=FUNCTION, x=array("n N"), u=array("m k"), name=NAME, rows=optional(count()))
def slopes(f: Map, x: np.ndarray, u: np.ndarray, *, name: str = "The map",
           rows: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """f(x) (p, N) and ∂f/∂x (N, p, n) at the columns of x (n, N): f(x + ihe_j) = f(x) + ih ∂f/∂x_j + O(h²), h = 1e-30.

    Exact to rounding. Squire and Trapp (1998). f must be analytic: no |x|, no comparisons. Raises ShapeError, EngineError.
    """
    n, N = x.shape
    many = (x[:, None, :] + 1j * COMPLEX_STEP * np.eye(n)[:, :, None]).reshape(n, n * N)
    unfit = EngineError("{name} cannot be differentiated by a complex step; give its slope.", name=name)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", np.exceptions.ComplexWarning)
            values = values_of(f, many, np.tile(u, (1, n)) if u.shape[1] == N and N > 1 else u, name, rows)
    except (TypeError, np.exceptions.ComplexWarning) as problem:
        raise unfit from problem
    if not np.iscomplexobj(values):
        raise unfit
    values = values.reshape(len(values), n, N)
    return np.real(values[:, 0]).copy(), (np.imag(values) / COMPLEX_STEP).transpose(2, 0, 1)


def slopes_known(f: Map, x: np.ndarray, u: np.ndarray, name: str, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """As `slopes`, for a map that has been seen to bear the complex step; of one state in half the time."""
    if x.shape[1] > 1:
        return slopes(f, x, u, name=name, rows=rows)
    values = values_of(f, x + _steps(len(x)), u, name, rows)
    return values.real[:, :1], (values.imag / COMPLEX_STEP)[None]


@lru_cache(maxsize=64)
def _steps(n: int) -> np.ndarray:
    """A complex step of each state, (n, n)."""
    found = 1j * COMPLEX_STEP * np.eye(n)
    found.flags.writeable = False
    return found


def central_slopes(f: Map, x: np.ndarray, u: np.ndarray, spread: np.ndarray, *, name: str = "The map",
                   rows: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """f(x) (p, N) and ∂f/∂x (N, p, n) by central differences, for maps that no complex step differentiates; `spread` (n,) is how far
    the states may lie from x."""
    n, N = x.shape
    step = CENTRAL_STEP * np.maximum(np.abs(x), np.where(spread > 0, spread, 1.0)[:, None])
    moved = step * np.eye(n)[:, :, None]
    many = np.concatenate([x[:, None, :], x[:, None, :] + moved.transpose(1, 0, 2), x[:, None, :] - moved.transpose(1, 0, 2)], axis=1)
    inputs = np.tile(u, (1, 2 * n + 1)) if u.shape[1] == N and N > 1 else u
    values = values_of(f, many.reshape(n, -1), inputs, name, rows).reshape(-1, 2 * n + 1, N)
    return values[:, 0].copy(), ((values[:, 1:n + 1] - values[:, n + 1:]) / (2 * step)).transpose(2, 0, 1)


def complex_step_fits(f: Map, x: np.ndarray, u: np.ndarray, spread: np.ndarray, *, name: str, rows: int) -> bool:
    """Whether the complex step gives the slopes that central differences give, at x (n,) and beside it; f is asked at real states
    first, so that what it raises itself comes through."""
    n = len(x)
    odd = np.arange(n) % 2 == 0
    points = x[:, None] + np.where(odd[:, None], *np.array(PLACES).T[:, None]) * np.where(spread > 0, spread, 0.0)[:, None]
    points = points + (points == 0) * 1e-3 * np.where(spread > 0, spread, 1.0)[:, None]
    values, differences = central_slopes(f, points, u[:, :1], spread, name=name, rows=rows)
    if not np.allclose(values_of(f, points[:, -1:], u[:, :1], name, rows)[:, 0], values[:, -1], rtol=1e-9,
                       atol=1e-9 * float(np.abs(values[np.isfinite(values)]).max(initial=0.0)), equal_nan=True):
        raise EngineError("{name} cannot be differentiated by a complex step; give its slope.", name=name)  # it mixes its columns
    try:
        exact = slopes(f, points, u[:, :1], name=name, rows=rows)[1]
    except (EngineError, TypeError, ValueError):
        return False
    step = CENTRAL_STEP * np.where(spread > 0, np.maximum(spread, np.abs(points).min(axis=1)), 1.0)
    rounding = 100 * float(np.finfo(float).eps) * np.abs(values).T[:, :, None] / step
    gap = np.abs(exact - differences)
    told = np.isfinite(differences)
    return bool((gap <= ALIKE * np.maximum(np.abs(exact), np.abs(differences)) + rounding)[told].all())
