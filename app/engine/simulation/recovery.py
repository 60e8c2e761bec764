"""Map which starts recover, over one entry of x(0) and one of e(0)."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import INTEGER, SERIES, instance, number, optional, takes
from ..systems.records import record
from .batch import RunBatch
from .scenario import Scenario

__all__ = ["RecoveryMap", "simulate_recovery"]

SLICE_S = 0.010  # seconds of work between two yields
MOST_STARTS = 250_000
TIMING_STEPS = 8  # compiled steps before it is known how long they take
RECOVERED_SHARE = 0.05  # of the largest start on the map
LOST_FACTOR = 1e3


@record()
class RecoveryMap:
    """Starts that recover: at the time reached ‖x‖ is below `threshold` and it never exceeded `bound`.

    x_values (n_x,), e_values (n_e,), recovered bool (n_x, n_e), settling (n_x, n_e): seconds after which ‖x‖ stays
    below `threshold`, infinite where it does not.
    """

    x_values: np.ndarray
    e_values: np.ndarray
    recovered: np.ndarray
    settling: np.ndarray
    threshold: float
    bound: float


def _axis(values: object, name: str) -> np.ndarray:
    axis = np.atleast_1d(np.asarray(values, dtype=float))
    if axis.ndim != 1 or not axis.size or not np.isfinite(axis).all():
        raise EngineError("{name} must be a list of finite numbers.", name=name)
    return axis


@takes(s=instance(Scenario), x_index=INTEGER, x_values=SERIES, e_index=INTEGER, e_values=SERIES)
def starts_of(s: Scenario, x_index: int, x_values: np.ndarray, e_index: int, e_values: np.ndarray) -> np.ndarray:
    """The starts (n_x·n_e, 2n): x(0) and e(0) of the scenario with one entry each replaced, x̂(0) = x(0) − e(0)."""
    n = s.plant.n
    if s.model.n != n:
        raise ShapeError("A map over e(0) needs a model of the plant's own order.")
    if not (0 <= x_index < n and 0 <= e_index < n):
        raise EngineError("The state indices of the map must lie between 0 and {n}.", n=n - 1)
    if len(x_values) * len(e_values) > MOST_STARTS:
        raise EngineError("A map of {count} starts is too large; keep it to {most_starts}.",
                          count=len(x_values) * len(e_values), most_starts=MOST_STARTS)
    x = np.tile(s.x0, (len(x_values), len(e_values), 1))
    e = np.tile(s.x0 - s.xhat0, (len(x_values), len(e_values), 1))
    x[:, :, x_index] = x_values[:, None]
    e[:, :, e_index] = e_values[None, :]
    return np.concatenate([x, x - e], axis=2).reshape(-1, 2 * n)


@takes(scenario=instance(Scenario), x_index=INTEGER, x_values=SERIES, e_index=INTEGER, e_values=SERIES,
       threshold=optional(number(above=0, high=1e+100)), bound=optional(number(above=0, high=1e+100)), slice_seconds=number(0))
def simulate_recovery(scenario: Scenario, x_index: int, x_values: object, e_index: int, e_values: object, *,
                 threshold: float | None = None, bound: float | None = None,
                 slice_seconds: float = SLICE_S) -> Iterator[tuple[float, RecoveryMap]]:
    """Run every start of the grid and yield (fraction done, map so far) about every `slice_seconds`, (1.0, map) last.

    x(0)[x_index] runs over x_values, e(0)[e_index] over e_values, all else as in the scenario; x̂(0) = x(0) − e(0).
    A map so far says which starts are inside the threshold at the time reached. Defaults: threshold 5 % of the
    largest ‖x(0)‖ on the map (of ‖e(0)‖ if that is zero), bound a thousand times it. All starts share the noise.
    Raises EngineError or ShapeError for a grid the scenario cannot have.
    """
    axes = _axis(x_values, "x_values"), _axis(e_values, "e_values")
    starts = starts_of(scenario, x_index, axes[0], e_index, axes[1])
    n, dt, steps = scenario.plant.n, scenario.dt, scenario.n_t - 1
    x0 = starts[:, :n]
    size = float(np.max(np.linalg.norm(x0, axis=1))) or float(np.max(np.linalg.norm(x0 - starts[:, n:], axis=1))) or 1.0
    near = RECOVERED_SHARE * size if threshold is None else float(threshold)
    far = LOST_FACTOR * size if bound is None else float(bound)
    herd = RunBatch(scenario)
    Z, k, count = herd.started(starts), 0, TIMING_STEPS
    lost, last_out = np.zeros(len(starts), dtype=bool), np.full(len(starts), -1)
    judge = np.array([n, near**2, far**2, 1e6 * far, np.inf])
    _judge(Z, 0, judge, last_out, lost)
    began = since = time.perf_counter()
    while True:
        if k == steps or time.perf_counter() - began >= slice_seconds:
            yield k / steps, _map(axes, lost | (last_out == k), (last_out + 1) * dt, near, far)
            began = since = time.perf_counter()
        if k == steps:
            return
        if now := herd.compiled(k, count):
            herd.along(Z, k, now, np.empty((0, *Z.shape)), judge, last_out, lost)
            Z[lost] = 0.0
            took, since = time.perf_counter() - since, time.perf_counter()
            count = max(1, min(4 * count, int(count * slice_seconds / max(took, 1e-9))))
        else:
            Z, now = herd.step(Z, k), 1
            _judge(Z, k + 1, judge, last_out, lost)
        k += now


def _judge(Z: np.ndarray, k: int, judge: np.ndarray, last_out: np.ndarray, lost: np.ndarray) -> None:
    """Note which runs are out at step k and which are lost; these rest at zero from here on."""
    n, near, far, rest, _ = judge
    square = np.einsum("ij,ij->i", Z[:, :int(n)], Z[:, :int(n)])
    last_out[square >= near] = k
    lost |= (square > far) | (np.abs(Z[:, int(n):]).max(axis=1) > rest)
    Z[lost] = 0.0


def _map(axes: tuple[np.ndarray, np.ndarray], out: np.ndarray, inside_since: np.ndarray, near: float,
         far: float) -> RecoveryMap:
    shape = len(axes[0]), len(axes[1])
    return RecoveryMap(*axes, ~out.reshape(shape), np.where(out, np.inf, inside_since).reshape(shape), near, far)
