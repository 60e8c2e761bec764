"""Filter a record by a nonlinear filter, sample by sample."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ...systems.arrays import all_finite, as_covariance, as_numbers
from ...systems.errors import EngineError, ShapeError
from ...systems.flow import Flow
from ...systems.gates.map_roles import NeedsTime
from ...systems.jacobian import Map
from ..belief import Belief
from ..moments import Moments
from ..track import Schedule, Track

__all__ = ["filtered", "noises_of"]

ALIKE = 1e-9  # relative difference of steps that are the same


class Steps(Protocol):
    """What a run asks of a nonlinear filter."""

    f: Map
    h: Map
    Q: np.ndarray

    @property
    def n(self) -> int: ...
    @property
    def p(self) -> int: ...
    @property
    def in_time(self) -> Steps: ...
    def taken_in(self, belief: Belief, y: np.ndarray, u: np.ndarray, *, R: np.ndarray | None = None) -> tuple[np.ndarray, ...]: ...
    def lead(self, belief: Belief, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]: ...


def noises_of(model: Steps, Q: object, moments: Moments, steps: int) -> np.ndarray:
    """Q of each step, (n_t − 1 or 1, n, n): as given, one or one a sample; of a `Flow` in irregular steps in proportion to their length."""
    n = model.n
    if Q is not None:
        given = as_numbers(Q, "Q")
        if given.ndim < 3:
            return as_covariance(given, "Q", n)[None]
        if len(given) not in (steps - 1, steps) or given.shape[1:] != (n, n):
            raise ShapeError("{name} must be {size}×{size}, or one such matrix a sample; its shape is {array_shape}.",
                             name="Q", size=n, array_shape=given.shape)
        return np.array([as_covariance(one, "Q", n) for one in given[:steps - 1]])
    if moments.t is None:
        return model.Q[None]
    spans = np.diff(moments.t)
    if isinstance(model.f, Flow):
        return model.Q * (spans / model.f.step)[:, None, None] if len(spans) else model.Q[None]
    if "dt" not in getattr(model.f, "roles", ()) and spans.size and np.ptp(spans) > ALIKE * np.abs(moments.t).max():
        raise EngineError("Irregular times need an f that is a Flow or takes dt; this f makes steps of one length.")
    return model.Q[None]


def filtered(model: Steps, start: Belief, y: np.ndarray, inputs: np.ndarray, moments: Moments, Q: np.ndarray) -> Track:
    """A record y (n_t, p) with inputs (n_t, m); see `NonlinearFilter.run`."""
    steps, n, p = len(y), model.n, model.p
    if moments.t is not None or isinstance(model.f, NeedsTime) or isinstance(model.h, NeedsTime):
        t = np.arange(steps, dtype=float) if moments.t is None else moments.t
        inputs, model = np.column_stack([inputs, t, np.diff(t, append=t[-1:])]), model.in_time
    predicted, means, innovations = np.empty((steps, n)), np.empty((steps, n)), np.empty((steps, p))
    prior, posterior, S, gains = (np.empty((steps, *shape)) for shape in ((n, n), (n, n), (p, p), (n, p)))
    across, rejected, each = np.empty((max(steps - 1, 0), n, n)), np.zeros(steps, dtype=bool), len(Q) > 1
    belief, R = start, moments.noise(0)
    for k, (seen, given) in enumerate(zip(y, inputs[:, :, None], strict=True)):
        predicted[k], prior[k] = belief.mean, belief.covariance
        innovations[k], S[k], gains[k], x, P = model.taken_in(belief, seen, given, R=moments.noise(k) if k and len(moments.R) > 1 else R)
        if moments.levels is not None and moments.refuses(k, innovations[k], S[k], ~np.isnan(seen)):
            rejected[k], gains[k], x, P = True, 0.0, belief.mean, belief.covariance
        means[k], posterior[k] = x, P
        if k + 1 < steps:
            x, P, across[k] = model.lead(Belief.bare(x, P), given)
            if not all_finite(x):
                raise EngineError("{name} gave NaN or infinity: the estimate has left the region where the model holds.",
                                  name="f" if np.isfinite(means[k]).all() else "h")
            belief = Belief.bare(x, P + Q[k if each else 0])
    if not np.isfinite(means[-1]).all():
        raise EngineError("{name} gave NaN or infinity: the estimate has left the region where the model holds.", name="h")
    return Track(predicted, means, innovations, Schedule(steps, prior, posterior, S, gains), across,
                 None if moments.levels is None else rejected)
