"""Simulate many runs of a nonlinear plant with several filters on what they share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ...systems.errors import EngineError, ShapeError
from ...systems.flow import Flow
from ...systems.gates.argument_checks import (
    FUNCTION,
    GENERATOR,
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
    takes,
    takes_runs,
    vector,
)
from ...systems.jacobian import Map
from ...systems.noise import root
from ...systems.records import record
from ..belief import Beliefs, Corrections
from .extended import ExtendedKalmanFilter
from .nonlinear_filter import NonlinearFilter

__all__ = ["Experiment", "Sample", "Steering", "errors_squared", "simulate_filters"]

GIVE_UP_LIMIT = 1e12  # a state, an estimate or a variance beyond this is given up


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


@takes(e=instance(Experiment), rng=GENERATOR)
def simulate_filters(e: Experiment, rng: np.random.Generator) -> Iterator[Sample]:
    """Yield one sample after another; noise is drawn from `rng`, the same whichever filters watch.

    Raises EngineError where a true state leaves the region in which the plant's equations hold.
    """
    n, N = e.x0.shape
    if e.start.mean.shape != (n, N):
        raise ShapeError("The start is about {mean_shape} states and runs; the true states are {value}.",
                         mean_shape=e.start.mean.shape, value=(n, N))
    shake, blur, p = root(e.Q), root(e.R), len(e.R)
    now = State(e.x0, dict.fromkeys(e.filters, e.start), {name: np.zeros(N, dtype=bool) for name in e.filters})
    count = len(e.inputs)
    for k in range(count):
        noise = rng.standard_normal((p + n, N))
        sample = _corrected(e, k, now, blur @ noise[:p])
        yield sample
        if k + 1 < count:
            now = _moved(e, sample, shake @ noise[p:])


def _corrected(e: Experiment, k: int, now: State, v: np.ndarray) -> Sample:
    x, known = now.x, e.inputs[k][:, None]
    for at, jump in e.kicks:
        if at == k:
            x = now.x + jump[:, None]
    y = e.output(x, known) + v
    steps: dict[str, Corrections] = {}
    lost: dict[str, np.ndarray] = {}
    for name, filter_ in e.filters.items():
        with np.errstate(all="ignore"):
            step = filter_.correct(now.priors[name], y, known)
        beliefs, lost[name] = _kept(step.beliefs, now.lost[name], e.start)
        steps[name] = step if beliefs is step.beliefs else replace(step, beliefs=beliefs)
    return Sample(k, x, y, known if e.steering is None else _steered(e.steering, known, steps), steps, lost)


def _moved(e: Experiment, sample: Sample, w: np.ndarray) -> State:
    with np.errstate(over="ignore", invalid="ignore"):
        x, priors = _ahead(e, sample.x, sample.u, sample.corrections)
        x = x + w
    if not (np.abs(x) < GIVE_UP_LIMIT).all():
        raise EngineError("A true state has left the region where the plant's equations hold; start it nearer "
                          "to rest.")
    return State(x, priors, sample.lost)


def _ahead(e: Experiment, x: np.ndarray, u: np.ndarray,
           steps: Mapping[str, Corrections]) -> tuple[np.ndarray, dict[str, Beliefs]]:
    """States and beliefs one step later; all that needs the flow goes through it at once, slopes at the front."""
    n, N = x.shape
    ahead: dict[str, Beliefs] = {}
    expanded: dict[str, ExtendedKalmanFilter] = {}
    pointed: dict[str, np.ndarray] = {}
    for name, filter_ in e.filters.items():
        if filter_.f is e.flow and isinstance(filter_, ExtendedKalmanFilter) and isinstance(e.flow, Flow):
            expanded[name] = filter_
        elif filter_.f is e.flow and (points := filter_.wanted(steps[name].beliefs)) is not None:
            pointed[name] = points
        else:
            ahead[name] = filter_.predict(steps[name].beliefs, u)
    means = [steps[name].beliefs.mean[:, None] for name in expanded]
    together = np.concatenate([*means, *pointed.values(), x[:, None]], axis=1)
    flat, each = together.reshape(n, -1), np.tile(u, (1, together.shape[1])) if u.shape[1] == N and N > 1 else u
    images, F = e.flow.expand(flat, each, lead=N * len(means)) if expanded and isinstance(e.flow, Flow) else (e.flow(flat, each), x)
    images = images.reshape(n, -1, N)
    for i, (name, filter_) in enumerate(expanded.items()):
        ahead[name] = filter_.along(steps[name].beliefs, images[:, i], F[i * N:(i + 1) * N])
    at = len(means)
    for name, points in pointed.items():
        ahead[name] = e.filters[name].predicted(steps[name].beliefs, images[:, at:at + points.shape[1]])
        at += points.shape[1]
    return images[:, -1], ahead


def _steered(s: Steering, known: np.ndarray, steps: Mapping[str, Corrections]) -> np.ndarray:
    limit = s.u_max[:, None]
    return np.clip(known - s.gain @ steps[s.by].beliefs.mean, -limit, limit)


def _kept(beliefs: Beliefs, lost: np.ndarray, start: Beliefs) -> tuple[Beliefs, np.ndarray]:
    """The beliefs with the runs given up put back to the start, and which those are."""
    mean, P = beliefs.mean, beliefs.covariance
    variances = np.diagonal(P, axis1=1, axis2=2)
    if np.abs(mean).max() < GIVE_UP_LIMIT and variances.min() > 0 and variances.max() < GIVE_UP_LIMIT and not lost.any():
        return beliefs, lost
    bad = ~((np.abs(mean) < GIVE_UP_LIMIT).all(axis=0) & ((variances > 0) & (variances < GIVE_UP_LIMIT)).all(axis=1))
    lost = lost | bad
    if len(P) == 1 and len(lost) > 1:
        P = np.repeat(P, len(lost), axis=0)
    mean, P = mean.copy(), P.copy()
    mean[:, lost] = start.mean[:, lost]
    P[lost] = start.covariance[lost]
    return Beliefs(mean, P), lost


@takes_runs(e=array("… n", missing=True, infinite=True), P=array("… n n", missing=True, infinite=True))
def errors_squared(e: np.ndarray, P: np.ndarray) -> np.ndarray:
    """eᵀ P⁻¹ e (…,) of errors e (…, n) with covariances P (…, n, n); NaN where P is not finite and positive definite.

    States are brought to unit variance first, so that units do not matter.
    """
    try:
        P = np.broadcast_to(P, (*e.shape, e.shape[-1]))
    except ValueError as problem:
        raise ShapeError("{name} must be {size}×{size}, or one such matrix a sample; its shape is {array_shape}.",
                         name="P", size=e.shape[-1], array_shape=P.shape) from problem
    spread = np.sqrt(np.maximum(np.diagonal(P, axis1=-2, axis2=-1), 1e-300))
    correlation = P / (spread[..., :, None] * spread[..., None, :])
    scaled = (e / spread)[..., None]
    if e.shape[-1] == 1:
        return np.where(P[..., 0, 0] > 0, scaled[..., 0, 0]**2, np.nan)
    try:
        half = np.linalg.solve(np.linalg.cholesky(correlation), scaled)
        return (half[..., 0]**2).sum(axis=-1)
    except np.linalg.LinAlgError:
        finite = np.isfinite(correlation).all(axis=(-1, -2))[..., None, None]
        values, vectors = np.linalg.eigh(np.where(finite, correlation, -np.eye(e.shape[-1])))
        turned = (vectors.swapaxes(-1, -2) @ scaled)[..., 0]
        good = values[..., 0] > 0
        squares = (turned**2 / np.where(values > 0, values, 1.0)).sum(axis=-1)
        return np.where(good, squares, np.nan)
