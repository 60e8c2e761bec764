"""Filter with two to four models at once, between which the plant switches (IMM)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..plotting import plot_estimates
from ..systems.arrays import as_numbers, frozen, symmetric
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import RECORD, gated, instance, items, matrix, optional, passed, vector
from ..systems.records import record
from .belief import BELIEF, Belief, Correction
from .linear.linear_filter import LinearFilter
from .moments import surprise
from .nonlinear.differences import minus, plus
from .nonlinear.nonlinear_filter import NonlinearFilter
from .track import as_record

if TYPE_CHECKING:
    from ..plotting import Axes

__all__ = ["ModelTrack", "MultipleModelFilter"]

FEWEST, MOST = 2, 4
SUM_ERROR = 1e-9  # of probabilities that add up to one


@record()
class ModelTrack:
    """A record filtered by several models: means (n_t, n), covariances (n_t, n, n), probabilities of the models (n_t, M).

    each: the means of every model (n_t, M, n).
    """

    means: np.ndarray
    covariances: np.ndarray
    probabilities: np.ndarray
    each: np.ndarray

    @property
    def likeliest(self) -> np.ndarray:
        """The number of the most probable model at each sample (n_t,), counted from 0.

        >>> ModelTrack(np.zeros((1, 1)), np.ones((1, 1, 1)), np.array([[0.1, 0.9]]), np.zeros((1, 2, 1))).likeliest
        array([1])
        """
        return np.argmax(self.probabilities, axis=1)

    def plot(self, *, dt: float = 0.0) -> list[Axes]:
        """The means with two standard deviations to either side, a panel each state."""
        return plot_estimates(self.means, np.diagonal(self.covariances, axis1=1, axis2=2), dt=dt)


@record()
class MultipleModelFilter:
    """The interacting multiple-model filter: two to four filters of the same states and readings, one of which is right at a time.

    switching (M×M): the probability that model i is followed by model j at the next sample, rows add up to 1. Before each step the
    beliefs are mixed by μ_ij = Π_ij μ_i / Σ_i Π_ij μ_i, afterwards μ_j ∝ Σ_i Π_ij μ_i N(ν_j; 0, S_j). Blom and Bar-Shalom (1988).
    Raises ShapeError, EngineError.

    >>> still, moving = (KalmanFilter([[1]], [[0]], [[1]], q, 1.0) for q in (0.01, 9.0))
    >>> both = MultipleModelFilter([still, moving], [[0.95, 0.05], [0.05, 0.95]])
    >>> both.run(([0], 1.0), [0.0, 0.1, 6.0, 12.0]).likeliest
    array([0, 0, 1, 1])
    """

    filters: tuple[LinearFilter | NonlinearFilter, ...]
    switching: np.ndarray

    def __post_init__(self) -> None:
        passed(self, filters=items(instance(LinearFilter, NonlinearFilter), MOST), switching=matrix())
        M = len(self.filters)
        if not FEWEST <= M <= MOST:
            raise EngineError("A filter of several models has {few} to {most}; {count} were given.", few=FEWEST, most=MOST, count=M)
        if self.switching.shape != (M, M):
            raise ShapeError("{name} must be {must}; it is {it_is}.", name="switching", must=f"{M}×{M}",
                             it_is="×".join(map(str, self.switching.shape)))
        outside = (self.switching < 0).any() or (self.switching > 1 + SUM_ERROR).any()
        if outside or (np.abs(self.switching.sum(axis=1) - 1) > SUM_ERROR).any():
            raise EngineError("Each row of switching must hold probabilities that add up to 1.")

    @gated(y=RECORD, start=BELIEF, probabilities=optional(vector()))
    def run(self, start: object, y: object, u: object | None = None, *, probabilities: object | None = None) -> ModelTrack:
        """A record y (n_t, p) with inputs u (n_t, m) filtered; `start`, a Belief or (mean, covariance), is before the first reading.

        probabilities (M,) of the models at the first sample, alike if left out. A reading that is NaN did not arrive.
        """
        belief = BELIEF(start, "start", {})
        n, p = belief.mean.size, y.shape[1] if isinstance(y, np.ndarray) and y.ndim == 2 else 1
        filters = [one.fitting(n, p) if isinstance(one, NonlinearFilter) else one for one in self.filters]
        y = as_record(y, "y", p)
        given = None if u is None else as_numbers(u, "u")
        inputs = [()] * len(y) if given is None else as_record(given, "u", given.shape[1] if given.ndim == 2 else 1, rows=len(y))
        mu, beliefs, rows = self._first(probabilities), [belief] * len(filters), []
        for k in range(len(y)):
            if k:
                mu, beliefs = self._mixed(mu, beliefs)
                beliefs = [_led(one, b, inputs[k - 1]) for one, b in zip(filters, beliefs, strict=True)]
            steps = [_heard(one, b, y[k], inputs[k]) for one, b in zip(filters, beliefs, strict=True)]
            mu, beliefs = _weighed(mu, steps), [step.belief for step in steps]
            rows.append((*self._together(mu, beliefs), mu, np.array([b.mean for b in beliefs])))
        return ModelTrack(*(frozen(np.array(part)) for part in zip(*rows, strict=True)))

    def _first(self, probabilities: object) -> np.ndarray:
        M = len(self.filters)
        mu = np.full(M, 1 / M) if probabilities is None else np.asarray(probabilities)
        if mu.size != M or (mu < 0).any() or abs(mu.sum() - 1) > SUM_ERROR:
            raise EngineError("The probabilities of the models must be {count} numbers that add up to 1.", count=M)
        return mu

    def _mixed(self, mu: np.ndarray, beliefs: list[Belief]) -> tuple[np.ndarray, list[Belief]]:
        """What each model begins a step with, and how probable it is then."""
        joint = self.switching * mu[:, None]
        ahead = joint.sum(axis=0)
        parts = joint / np.where(ahead > 0, ahead, 1.0)
        return ahead, [Belief.bare(*self._together(parts[:, j], beliefs)) if ahead[j] > 0 else b for j, b in enumerate(beliefs)]

    def _together(self, weights: np.ndarray, beliefs: list[Belief]) -> tuple[np.ndarray, np.ndarray]:
        """Mean and covariance of a mixture of beliefs."""
        first = self.filters[0]
        apart, joined = (first.x_minus, first.x_plus) if isinstance(first, NonlinearFilter) else (None, None)
        middle = beliefs[int(np.argmax(weights))].mean
        mean = plus(joined, middle, sum(w * minus(apart, b.mean, middle) for w, b in zip(weights, beliefs, strict=True)))
        away = [minus(apart, b.mean, mean) for b in beliefs]
        return mean, symmetric(sum(w * (b.covariance + np.outer(d, d)) for w, b, d in zip(weights, beliefs, away, strict=True)))


def _led(one: LinearFilter | NonlinearFilter, belief: Belief, u: object) -> Belief:
    return one.predict(belief, None if isinstance(one, LinearFilter) and not np.size(u) else u)  # type: ignore[arg-type]


def _heard(one: LinearFilter | NonlinearFilter, belief: Belief, y: np.ndarray, u: object) -> Correction:
    return one.correct(belief, y, None if isinstance(one, LinearFilter) and not np.size(u) else u)  # type: ignore[arg-type]


def _weighed(mu: np.ndarray, steps: list[Correction]) -> np.ndarray:
    """The probabilities after a reading, by logarithms, so that none is lost where all models are surprised."""
    logs = np.empty(len(steps))
    for j, step in enumerate(steps):
        seen = np.isfinite(step.innovation)
        within = step.S[np.ix_(seen, seen)]
        logs[j] = -(surprise(step.innovation, step.S, seen) + np.linalg.slogdet(within)[1]) / 2 if seen.any() else 0.0
    found = mu * np.exp(logs - logs[mu > 0].max())
    return found / found.sum()
