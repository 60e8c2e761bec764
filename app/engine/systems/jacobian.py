"""Values and derivatives of maps of the state, many states at a time."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np

from .errors import EngineError, ShapeError

__all__ = ["columns", "each_column", "expand", "jacobian"]

Map = Callable[[np.ndarray, np.ndarray], np.ndarray]
STEP = 1e-30  # of the complex step, relative to nothing: its square is below every rounding


def each_column(one: Map) -> Map:
    """A map of columns, x (n, N) and u (m, 1), from a function of one state x (n,) and input u (m,)."""
    def many(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.stack([np.asarray(one(column, u[:, 0])) for column in x.T], axis=1)

    return many


def columns(f: Map, x: np.ndarray, u: np.ndarray, name: str, rows: int) -> np.ndarray:
    """f at the states in the columns of x (n, N): (rows, N). Raises ShapeError, EngineError with `name` in it."""
    values = np.asarray(f(x, u[:, None]))
    if values.shape != (rows, x.shape[1]):
        raise ShapeError("{name} must return {rows} rows and a column for each state; for {columns} states its "
                         "result has the shape {values_shape}. each_column wraps a function of one state.",
                         name=name, rows=rows, columns=x.shape[1], values_shape=values.shape)
    if not np.isfinite(values).all():
        raise EngineError("{name} gave NaN or infinity: the estimate has left the region where the model holds.",
                          name=name)
    return values


def jacobian(f: Map, x: np.ndarray, u: np.ndarray, name: str, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """f(x) (rows,) and ∂f/∂x (rows × n) from one call: f(x + ihe_j) = f(x) + ih ∂f/∂x_j + O(h²), h = 1e-30.

    Squire and Trapp (1998). Raises EngineError where f cannot be called with complex states.
    """
    unfit = EngineError("{name} cannot be differentiated by a complex step; give its Jacobian.", name=name)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", np.exceptions.ComplexWarning)
            values = columns(f, x[:, None] + 1j * STEP * np.eye(x.size), u, name, rows)
    except (TypeError, np.exceptions.ComplexWarning) as problem:
        raise unfit from problem
    if not np.iscomplexobj(values):
        raise unfit
    return np.real(values[:, 0]).copy(), np.imag(values) / STEP


def expand(f: Map, derivative: Map | None, x: np.ndarray, u: np.ndarray, name: str,
           rows: int) -> tuple[np.ndarray, np.ndarray]:
    """f(x) and its Jacobian at one state x (n,), by the `derivative` given or by a complex step."""
    if derivative is None:
        return jacobian(f, x, u, name, rows)
    slope = np.asarray(derivative(x, u), dtype=float)
    if slope.shape != (rows, x.size):
        raise ShapeError("The Jacobian of {name} must be {rows}×{x_size}; its shape is {slope_shape}.",
                         name=name, rows=rows, x_size=x.size, slope_shape=slope.shape)
    return columns(f, x[:, None], u, name, rows)[:, 0], slope
