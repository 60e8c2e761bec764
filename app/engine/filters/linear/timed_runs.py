"""Filter a record whose samples have their own times, noises and gates."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy.linalg import expm

from ...systems.arrays import symmetric
from ...systems.errors import EngineError
from ...systems.plant import Plant
from ...systems.records import record
from ..belief import Belief
from ..moments import Moments
from ..track import Schedule, Track

__all__ = ["Source", "timed_run"]


@record()
class Source:
    """The continuous plant that a filter samples, and the intensity G W Gᵀ (n×n) of its noise."""

    plant: Plant
    intensity: np.ndarray

    def steps(self, spans: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Φ (k, n, n), ∫Φ B (k, n, m) and Q (k, n, n) over each span in s, the input held: Van Loan (1978), many at once.

        Spans are halved until ‖A‖h ≤ 1/2 and doubled again, as `step_covariance` does.
        """
        A, B, n, m = self.plant.A, self.plant.B, self.plant.n, self.plant.m
        longest = float(spans.max(initial=0.0)) * max(float(np.linalg.norm(A, 1)), 1e-300)
        doublings = max(0, int(np.ceil(np.log2(max(longest, 1e-300)))) + 1)
        h = (spans / 2**doublings)[:, None, None]
        wide = np.zeros((2 * n + m, 2 * n + m))
        wide[:n, :n], wide[:n, n:2 * n], wide[n:2 * n, n:2 * n] = -A, self.intensity, A.T
        power: np.ndarray = expm(wide[:2 * n, :2 * n] * h)
        drive = np.zeros((n + m, n + m))
        drive[:n, :n], drive[:n, n:] = A, B
        pushed: np.ndarray = expm(drive * h)
        Phi, Gamma = power[:, n:, n:].swapaxes(1, 2), pushed[:, :n, n:]
        Q = Phi @ power[:, :n, n:]
        for _ in range(doublings):
            Q = Q + Phi @ Q @ Phi.swapaxes(1, 2)
            Gamma = Gamma + Phi @ Gamma
            Phi = Phi @ Phi
        return Phi, Gamma, symmetric(Q)


class Steps(Protocol):
    """What a run asks of a linear filter."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    Q: np.ndarray
    source: Source | None

    @property
    def n(self) -> int: ...
    def spread(self, belief: Belief) -> np.ndarray: ...
    def covariance(self, spread: np.ndarray) -> np.ndarray: ...
    def forward(self, spread: np.ndarray, *, A: np.ndarray | None = None, Q: np.ndarray | None = None) -> np.ndarray: ...
    def corrected(self, spread: np.ndarray, seen: np.ndarray, *, R: np.ndarray | None = None) -> tuple[np.ndarray, ...]: ...


def timed_run(model: Steps, start: Belief, y: np.ndarray, u: np.ndarray | None, moments: Moments) -> Track:
    """A record y (n_t, p) with inputs u (n_t, m) or None, sample by sample; see `LinearFilter.run`."""
    steps, n, p = len(y), model.n, len(model.C)
    A, B, Q, which = _between(model, moments.t, steps)
    predicted, means, innovations = np.empty((steps, n)), np.empty((steps, n)), np.empty((steps, p))
    prior, posterior, S, gains = (np.empty((steps, *shape)) for shape in ((n, n), (n, n), (p, p), (n, p)))
    across, rejected = np.empty((max(steps - 1, 0), n, n)), np.zeros(steps, dtype=bool)
    x, spread, every = start.mean, model.spread(start), np.isfinite(y)
    known = y if u is None else y - u @ np.asarray(model.D).T
    for k in range(steps):
        predicted[k], prior[k], R, seen = x, model.covariance(spread), moments.noise(k), every[k]
        nu = innovations[k] = known[k] - model.C @ x
        S[k], gains[k], after = model.corrected(spread, seen, R=R)
        if moments.refuses(k, nu, S[k], seen):
            rejected[k], gains[k] = True, 0.0
        else:
            spread = after
            x = x + gains[k] @ (nu if seen.all() else np.where(seen, nu, 0.0))
        means[k], posterior[k] = x, model.covariance(spread)
        if k + 1 < steps:
            i = which[k]
            across[k] = posterior[k] @ A[i].T
            x = A[i] @ x if u is None else A[i] @ x + B[i] @ u[k]
            spread = model.forward(spread, A=A[i], Q=Q[i])
    return Track(predicted, means, innovations, Schedule(steps, prior, posterior, S, gains), across,
                 None if moments.levels is None else rejected)


def _between(model: Steps, t: np.ndarray | None, steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A, B, Q of each kind of step, and which kind follows each sample."""
    if t is None:
        return model.A[None], model.B[None], model.Q[None], np.zeros(max(steps - 1, 0), dtype=int)
    if model.source is None:
        raise EngineError("Irregular times need the continuous plant: make the filter with from_plant, or leave t out.")
    spans, which = np.unique(np.diff(t), return_inverse=True)
    return *model.source.steps(spans), which.reshape(-1)
