"""Filter by many weighted guesses of the state, drawn again where few carry the weight."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...plotting import plot_estimates
from ...systems.arrays import as_definite, as_numbers, frozen
from ...systems.errors import EngineError, ShapeError
from ...systems.gates.argument_checks import FUNCTION, GENERATOR, RECORD, count, covariance, gated, passed
from ...systems.jacobian import Map, values_of
from ...systems.noise import root
from ...systems.records import record
from ..belief import BELIEF
from ..track import as_record

if TYPE_CHECKING:
    from ...plotting import Axes

__all__ = ["ParticleFilter", "ParticleTrack"]

FEW = 0.5  # of the particles: below it they are drawn anew


@record()
class ParticleTrack:
    """Means x̂[k|k] (n_t, n), covariances (n_t, n, n), the effective number 1/Σw² of particles after each sample (n_t,), and the
    last particles (n, N) with their weights (N,)."""

    means: np.ndarray
    covariances: np.ndarray
    effective: np.ndarray
    particles: np.ndarray
    weights: np.ndarray

    def plot(self, *, dt: float = 0.0) -> list[Axes]:
        """The means with two standard deviations to either side, a panel each state."""
        return plot_estimates(self.means, np.diagonal(self.covariances, axis1=1, axis2=2), dt=dt)


@record()
class ParticleFilter:
    """The bootstrap filter for x[k+1] = f(x[k], u[k]) + w[k], y[k] = h(x[k], u[k]) + v[k], Gaussian w, v of covariances Q, R.

    f and h take states as columns, as `UnscentedKalmanFilter` does. Q is n×n ≥ 0, R p×p > 0. Each particle is led on with noise
    of its own and weighed by the likelihood of the measurement; where 1/Σw² falls below half of the particles they are drawn
    anew, evenly spaced (Gordon, Salmond and Smith 1993). A measurement that is NaN did not arrive.

    >>> pf = ParticleFilter(lambda x, u: x, lambda x, u: x, np.zeros((1, 1)), np.eye(1), particles=4000)
    >>> track = pf.run(([0.0], 1.0), [2.0], rng=np.random.default_rng(0))
    >>> bool(abs(track.means[0, 0] - 1.0) < 0.1)
    True
    """

    f: Map
    h: Map
    Q: np.ndarray
    R: np.ndarray
    particles: int = 1000

    def __post_init__(self) -> None:
        passed(self, f=FUNCTION, h=FUNCTION, Q=covariance(), R=covariance(), particles=count(2, 1_000_000))
        object.__setattr__(self, "R", as_definite(self.R, "R", len(self.R)))

    @gated(start=BELIEF, y=RECORD, rng=GENERATOR)
    def run(self, start: object, y: object, u: object | None = None, *, rng: np.random.Generator) -> ParticleTrack:
        """A record y (n_t, p) with inputs u (n_t, m) filtered; `start`, a Belief or (mean, covariance), is before the first sample."""
        belief, n, N = BELIEF(start, "start", {}), len(self.Q), self.particles
        if belief.mean.size != n:
            raise ShapeError("The belief is about {mean_size} states but Q is {n}×{n}; they must agree.", mean_size=belief.mean.size, n=n)
        y = as_record(y, "y", len(self.R))
        inputs = np.zeros((len(y), 0)) if u is None else as_numbers(u, "u")
        if u is not None:
            inputs = as_record(inputs, "u", inputs.shape[1] if inputs.ndim == 2 else 1, rows=len(y))
        x = belief.mean[:, None] + root(belief.covariance) @ rng.standard_normal((n, N))
        noise, weights = root(self.Q), np.full(N, 1 / N)
        means, covariances, effective = np.empty((len(y), n)), np.empty((len(y), n, n)), np.empty(len(y))
        for k in range(len(y)):
            weights = self._weighed(weights, x, y[k], inputs[k])
            means[k] = x @ weights
            apart = x - means[k][:, None]
            covariances[k], effective[k] = (apart * weights) @ apart.T, 1 / np.square(weights).sum()
            if k + 1 == len(y):
                break
            if effective[k] < FEW * N:
                x, weights = x[:, _drawn(weights, rng)], np.full(N, 1 / N)
            x = self._values(self.f, x, inputs[k], "f", n) + noise @ rng.standard_normal((noise.shape[1], N))
        return ParticleTrack(frozen(means), frozen(covariances), frozen(effective), frozen(x), frozen(weights))

    def _weighed(self, weights: np.ndarray, x: np.ndarray, y: np.ndarray, u: np.ndarray) -> np.ndarray:
        """w · p(y | x), made to add up to one; by logarithms, so that none is lost where all are unlikely."""
        seen = np.isfinite(y)
        if not seen.any():
            return weights
        apart = y[seen, None] - self._values(self.h, x, u, "h", len(self.R))[seen]
        cost = np.sum(apart * np.linalg.solve(self.R[np.ix_(seen, seen)], apart), axis=0) / 2
        with np.errstate(divide="ignore"):
            logs = np.log(weights) - cost
        found = np.exp(logs - logs.max())
        return found / found.sum()

    def _values(self, f: Map, x: np.ndarray, u: np.ndarray, name: str, rows: int) -> np.ndarray:
        found = values_of(f, x, u.reshape(-1, 1), name, rows)
        if not np.isfinite(found).all():
            raise EngineError("{name} gave NaN or infinity: the estimate has left the region where the model holds.", name=name)
        return found


def _drawn(weights: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Which particles are drawn: evenly spaced steps through the sum of the weights, begun at random."""
    steps = (np.arange(len(weights)) + rng.random()) / len(weights)
    return np.minimum(np.searchsorted(np.cumsum(weights), steps), len(weights) - 1)
