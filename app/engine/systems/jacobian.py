"""Compute values and derivatives of maps of the state, many states at a time."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np

from .errors import EngineError, ShapeError
from .gates.argument_checks import FUNCTION, NAME, array, count, optional, takes

__all__ = ["each_column", "slopes", "values_of"]

Map = Callable[[np.ndarray, np.ndarray], np.ndarray]
COMPLEX_STEP = 1e-30  # of the complex step: its square is below every rounding


@takes(one=FUNCTION)
def each_column(one: Map) -> Map:
    """A map of columns, x (n, N) and u (m, 1), from a function of one state x (n,) and input u (m,).

    >>> each_column(lambda x, u: [x[0] * x[1]])(np.array([[1, 2], [3, 4]]), np.zeros((1, 1)))
    array([[3, 8]])
    """
    def many(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.stack([np.asarray(one(column, u[:, 0])) for column in x.T], axis=1)

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
