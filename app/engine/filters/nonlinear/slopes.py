"""Compute the slopes of a nonlinear plant along its runs."""

from __future__ import annotations

import numpy as np

from ...systems.errors import ShapeError
from ...systems.flow import NonlinearPlant
from ...systems.gates.argument_checks import SECONDS, array, count, instance, takes

__all__ = ["slopes_along"]


@takes(plant=instance(NonlinearPlant), step=SECONDS, x=array("n k"), u=array("m l"), parts=count(1, 100_000))
def slopes_along(plant: NonlinearPlant, step: float, x: np.ndarray, u: np.ndarray, *, parts: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """∂f/∂x (k, n, n) of a plant's flow over `step` s in so many parts, and ∂y/∂x (k, p, n), at states (n, k) and inputs (m, k).

    x[k+1] = f(x[k], u[k]); the derivative of the discrete map itself. u may have one column for all. Raises ShapeError.
    """
    if len(x) != plant.n or len(u) != plant.m or u.shape[1] not in (1, x.shape[1]):
        raise ShapeError("The plant has {n} states and {m} inputs: x needs {n} rows, u {m}, and a column for each state or one for all.",
                         n=plant.n, m=plant.m)
    return plant.flow(step, parts=parts).expand(x, u)[1], plant.output_slope(x, u)
