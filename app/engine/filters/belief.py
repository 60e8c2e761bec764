"""What a filter believes: a mean and a covariance, immutable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..systems.errors import EngineError, ShapeError

__all__ = ["Belief", "Correction", "RootBelief"]


@dataclass(frozen=True, eq=False)
class Belief:
    """A Gaussian belief about the state: mean x̂ (n,), covariance P (n×n) of x − x̂; read-only arrays.

    Raises ShapeError where the two do not fit, EngineError where an entry is not finite.
    """

    mean: np.ndarray
    covariance: np.ndarray

    def __post_init__(self) -> None:
        mean = np.array(self.mean, dtype=float).reshape(-1)
        covariance = np.array(self.covariance, dtype=float, ndmin=2)
        if covariance.shape != (mean.size, mean.size):
            raise ShapeError("The covariance of {mean_size} states must be {mean_size}×{mean_size}; its shape is "
                             "{covariance_shape}.",
                             mean_size=mean.size, covariance_shape=covariance.shape)
        if not (np.isfinite(mean).all() and np.isfinite(covariance).all()):
            raise EngineError("The belief holds NaN or infinity: the filter has diverged or was started wrongly.")
        mean.setflags(write=False)
        covariance.setflags(write=False)
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "covariance", covariance)

    @property
    def deviation(self) -> np.ndarray:
        """Standard deviation of each state (n,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


@dataclass(frozen=True, eq=False)
class RootBelief(Belief):
    """A belief that carries a root U (n×n) of its covariance, P = U Uᵀ, which keeps twice as many digits."""

    root: np.ndarray

    @classmethod
    def of(cls, mean: np.ndarray, root: np.ndarray) -> RootBelief:
        """The belief with mean x̂ and covariance U Uᵀ."""
        return cls(mean, root @ root.T, root)


@dataclass(frozen=True, eq=False)
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
