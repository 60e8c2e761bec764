"""Compute the slopes of a nonlinear plant along its runs, compiled where possible."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ...kernels import as_kernel_array, compiled_kernel
from ...kernels.bounds import slope_steps
from ...kernels.tape import Tape, recorded
from ...systems.errors import ShapeError
from ...systems.flow import NonlinearPlant
from ...systems.gates.argument_checks import SECONDS, array, count, instance, takes

__all__ = ["slopes_along"]

Tapes = tuple[Tape, Tape]


def tapes_of(plant: NonlinearPlant) -> Tapes | None:
    """What its equations and its output do, step by step, as the kernels want it; None where that cannot be written down."""
    with suppress(TypeError):  # a function that cannot be remembered
        rates, output = recorded(plant.rhs, plant.n, plant.m, plant.n), recorded(plant.output, plant.n, plant.m, plant.p)
        if isinstance(rates, Tape) and isinstance(output, Tape):
            return rates, output
    return None


@takes(plant=instance(NonlinearPlant), step=SECONDS, x=array("n k"), u=array("m l"), parts=count(1, 100_000))
def slopes_along(plant: NonlinearPlant, step: float, x: np.ndarray, u: np.ndarray, *, parts: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """∂f/∂x (k, n, n) of a plant's flow over `step` s in so many parts, and ∂y/∂x (k, p, n), at states (n, k) and inputs (m, k).

    x[k+1] = f(x[k], u[k]); the derivative of the discrete map itself. u may have one column for all. Raises ShapeError.
    """
    if len(x) != plant.n or len(u) != plant.m or u.shape[1] not in (1, x.shape[1]):
        raise ShapeError("The plant has {n} states and {m} inputs: x needs {n} rows, u {m}, and a column for each state or one for all.",
                         n=plant.n, m=plant.m)
    work = compiled_kernel(slope_steps)
    tapes = None if work is None else tapes_of(plant)
    if work is None or tapes is None:
        return plant.flow(step, parts=parts).expand(x, u)[1], plant.output_slope(x, u)
    F, H = np.empty((x.shape[1], plant.n, plant.n)), np.empty((x.shape[1], plant.p, plant.n))
    with np.errstate(all="ignore"):
        work(*tapes, step / parts, parts, as_kernel_array(x.T), as_kernel_array(np.broadcast_to(u, (plant.m, x.shape[1])).T), F, H)
    return F, H
