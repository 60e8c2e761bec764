"""Define a filter's belief: mean and covariance, in one run or in many."""

from __future__ import annotations

from typing import Self

import numpy as np

from ..systems.arrays import as_covariance, as_numbers, described, frozen
from ..systems.errors import EngineError, ShapeError, phrase
from ..systems.gates.argument_checks import Gate, count, vector
from ..systems.records import record

__all__ = ["BELIEF", "Belief", "Beliefs", "Correction", "Corrections", "RootBelief"]


def _told(value: object, name: str) -> np.ndarray:
    return as_numbers(value, name, missing=True, infinite=True)


@record()
class Belief:
    """A Gaussian belief about the state: mean x̂ (n,), covariance P (n×n) of x − x̂; read-only arrays.

    Raises ShapeError where the two do not fit, EngineError where an entry is not finite and for a covariance that is not
    symmetric and positive semidefinite.

    >>> Belief([0, 0], np.diag([4, 9])).deviation
    array([2., 3.])
    """

    mean: np.ndarray
    covariance: np.ndarray

    def __post_init__(self) -> None:
        self._take()
        object.__setattr__(self, "covariance", as_covariance(self.covariance, phrase("The covariance"), self.mean.size))

    @classmethod
    def computed(cls, mean: np.ndarray, covariance: np.ndarray, **more: np.ndarray) -> Self:
        """What a filter has found, taken as it is: rounding may have made its covariance indefinite, which the filter shows."""
        belief = object.__new__(cls)
        for name, value in {"mean": mean, "covariance": covariance, **more}.items():
            object.__setattr__(belief, name, value)
        belief._take()
        return belief

    @classmethod
    def bare(cls, mean: np.ndarray, covariance: np.ndarray) -> Self:
        """The same within a run, which looks at its numbers itself."""
        belief = object.__new__(cls)
        fields = belief.__dict__
        fields["mean"], fields["covariance"] = mean, covariance
        return belief

    def _take(self) -> None:
        mean = np.array(_told(self.mean, "mean")).reshape(-1)
        covariance = np.array(_told(self.covariance, phrase("The covariance")), ndmin=2)
        if covariance.shape != (mean.size, mean.size):
            raise ShapeError("The covariance of {mean_size} states must be {mean_size}×{mean_size}; its shape is "
                             "{covariance_shape}.",
                             mean_size=mean.size, covariance_shape=covariance.shape)
        if not (np.isfinite(mean).all() and np.isfinite(covariance).all()):
            raise EngineError("The belief holds NaN or infinity: the filter has diverged or was started wrongly.")
        object.__setattr__(self, "mean", frozen(mean))
        object.__setattr__(self, "covariance", frozen(covariance))

    @property
    def deviation(self) -> np.ndarray:
        """Standard deviation of each state (n,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


@record()
class RootBelief(Belief):
    """A belief that carries a root U (n×n) of its covariance, P = U Uᵀ, which keeps twice as many digits."""

    root: np.ndarray

    @classmethod
    def of(cls, mean: np.ndarray, root: np.ndarray) -> RootBelief:
        """The belief with mean x̂ and covariance U Uᵀ."""
        return cls.computed(mean, root @ root.T, root=root)


@record()
class Correction:
    """One measurement update: belief after it, innovation ν = y − ŷ (p,), its covariance S (p×p), gain M (n×p)."""

    belief: Belief
    innovation: np.ndarray
    S: np.ndarray
    gain: np.ndarray

    @property
    def nis(self) -> float:
        """The normalised innovation squared νᵀ S⁻¹ ν of the sensors that answered; χ² with their number."""
        seen = np.isfinite(self.innovation)
        nu = self.innovation[seen]
        return float(nu @ np.linalg.solve(self.S[np.ix_(seen, seen)], nu)) if seen.any() else 0.0


@record()
class Beliefs:
    """A Gaussian belief in each of N runs: means (n, N), covariances (N, n, n) or (1, n, n) where all share one.

    `points` (n, 2n + 1, N) are sigma points carried on instead of being drawn anew, by `PrintedUnscentedFilter` alone.
    """

    mean: np.ndarray
    covariance: np.ndarray
    points: np.ndarray | None = None

    def __post_init__(self) -> None:
        for name, dimensions in (("mean", 2), ("covariance", 3), ("points", 3)):
            value = getattr(self, name)
            if (name != "points" or value is not None) and not (isinstance(value, np.ndarray) and value.dtype.kind == "f"
                                                                and value.ndim == dimensions):
                raise ShapeError("{name} must be a NumPy array of numbers with {ndim} dimensions.", name=name, ndim=dimensions)

    @classmethod
    def alike(cls, mean: object, covariance: object, runs: int) -> Beliefs:
        """The same belief, mean (n,) and covariance (n×n), in every run."""
        middle, runs = vector()(mean, "mean", {}), count(1)(runs, "runs", {})
        P = as_covariance(covariance, phrase("The covariance"), middle.size)
        return cls(np.repeat(middle[:, None], runs, axis=1), np.repeat(P[None], runs, axis=0))


@record()
class Corrections:
    """One measurement taken in by every run: beliefs after it, innovations (p, N), their covariances S, gains M.

    S is (N, p, p) and M (N, n, p), or with 1 for N where all runs share one covariance.
    """

    beliefs: Beliefs
    innovation: np.ndarray
    S: np.ndarray
    gain: np.ndarray


def _belief(value: object, name: str, sizes: dict[str, int]) -> Belief:
    if isinstance(value, Belief):
        return value
    if isinstance(value, tuple | list) and len(value) == 2 and np.ndim(value[1]) in (0, 2):
        mean = as_numbers(value[0], name).reshape(-1)
        return Belief(mean, as_covariance(value[1], phrase("The covariance"), mean.size))
    raise EngineError("{name} must be a {kind}; {given} was given.", name=name, kind="Belief", given=described(value))


BELIEF: Gate = _belief  # a belief, or its (mean, covariance)
