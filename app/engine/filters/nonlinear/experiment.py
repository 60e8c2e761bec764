"""Define what many runs of a nonlinear plant share, and the record of each sample."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...systems.errors import EngineError
from ...systems.flow import Flow
from ...systems.gates.argument_checks import (
    FUNCTION,
    NAME,
    Gate,
    array,
    count,
    covariance,
    instance,
    items,
    matrix,
    optional,
    pair,
    passed,
    vector,
)
from ...systems.jacobian import Map
from ...systems.records import record
from ..belief import Beliefs, Corrections
from .nonlinear_filter import NonlinearFilter

__all__ = ["Experiment", "Sample", "Steering"]


def _named(value: object, name: str, sizes: dict[str, int]) -> object:
    if not isinstance(value, Mapping) or not all(isinstance(f, NonlinearFilter) for f in value.values()):
        raise EngineError("{name} must map names to filters of nonlinear plants.", name=name)
    return value


_FILTERS: Gate = _named


@record()
class Steering:
    """u = reference − K x̂, x̂ the estimate of the filter named `by`, clipped to ±u_max (m,)."""

    by: str
    gain: np.ndarray
    u_max: np.ndarray

    def __post_init__(self) -> None:
        passed(self, by=NAME, gain=matrix("m n"), u_max=array("m", infinite=True))


@record()
class Experiment:
    """What N runs share. x[k+1] = flow(x[k], u[k]) + w[k], y[k] = output(x[k]) + v[k], white w, v of covariances Q, R.

    x0 (n, N): true starts; start: the beliefs before the first measurement; inputs (n_t, m): known inputs, to which
    `steering` may add; kicks: (sample, jump of the true state (n,)), of which no filter is told.
    """

    flow: Flow | Map
    output: Map
    Q: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    start: Beliefs
    inputs: np.ndarray
    filters: Mapping[str, NonlinearFilter]
    steering: Steering | None = None
    kicks: tuple[tuple[int, np.ndarray], ...] = ()

    def __post_init__(self) -> None:
        passed(self, flow=FUNCTION, output=FUNCTION, x0=array("n N"), start=instance(Beliefs), inputs=array("k m"), Q=covariance("n"),
               R=covariance(), filters=_FILTERS, steering=optional(instance(Steering)), kicks=items(pair(count(), vector("n"))))
        if self.steering is not None and self.steering.by not in self.filters:
            raise EngineError("There is no filter called {name} to steer by.", name=self.steering.by)


@record()
class Sample:
    """Sample k of all runs: states x (n, N), readings y (p, N), inputs u (m, N) from here on, and each filter's corrections.

    lost (N,), by filter: runs that this filter has given up, its numbers no longer finite or no longer a covariance; its
    beliefs in these rest at those of its start and mean nothing.
    """

    k: int
    x: np.ndarray
    y: np.ndarray
    u: np.ndarray
    corrections: Mapping[str, Corrections]
    lost: Mapping[str, np.ndarray]


@record()
class State:
    """Where an experiment stands before a sample: true states (n, N), by filter beliefs, and which runs it has given up (N,)."""

    x: np.ndarray
    priors: Mapping[str, Beliefs]
    lost: Mapping[str, np.ndarray]
