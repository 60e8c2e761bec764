"""Check what a record says of each sample: its time, its noise, the gate that rejects outliers."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri

from ..systems.arrays import as_covariance, as_numbers
from ..systems.errors import EngineError, ShapeError
from ..systems.records import record

__all__ = ["Moments", "moments_of", "surprise"]


@record()
class Moments:
    """Of each sample of a record: t (n_t,) in s or None, covariances R (n_t or 1, p, p), levels (n_t,) of the gate or None."""

    t: np.ndarray | None
    R: np.ndarray
    levels: np.ndarray | None

    def noise(self, k: int) -> np.ndarray:
        """R of sample k (p×p)."""
        return self.R[k if len(self.R) > 1 else 0]

    def refuses(self, k: int, nu: np.ndarray, S: np.ndarray, seen: np.ndarray) -> bool:
        """Whether the gate rejects sample k: νᵀS⁻¹ν of the sensors that answered lies beyond its quantile of χ²."""
        return self.levels is not None and bool(seen.any()) and surprise(nu, S, seen) > chdtri(int(seen.sum()), 1 - self.levels[k])


def surprise(nu: np.ndarray, S: np.ndarray, seen: np.ndarray) -> float:
    """νᵀS⁻¹ν of the sensors that answered."""
    heard = nu[seen]
    return float(heard @ np.linalg.solve(S[np.ix_(seen, seen)], heard))


def moments_of(steps: int, own: np.ndarray, t: object, R: object, gate: object) -> Moments:
    """The moments of a record of so many samples; `own` (p×p) stands where R is left out. Raises ShapeError, EngineError."""
    return Moments(None if t is None else _times(t, steps), _covariances(R, own, steps), None if gate is None else _levels(gate, steps))


def _times(t: object, steps: int) -> np.ndarray:
    times = as_numbers(t, "t").reshape(-1)
    if times.size != steps:
        raise ShapeError("{name} must have {length} entries; it has {vector_size}.", name="t", length=steps, vector_size=times.size)
    if (np.diff(times) < 0).any():
        before = int(np.argmax(np.diff(times) < 0))
        raise EngineError("The times t must not go back: sample {k} is earlier than sample {before}.", k=before + 1, before=before)
    return times


def _covariances(R: object, own: np.ndarray, steps: int) -> np.ndarray:
    """One R for all samples, (1, p, p), or one each: (n_t, p, p), of one sensor its variances (n_t,) too."""
    if R is None:
        return own[None]
    p, given = len(own), as_numbers(R, "R")
    if given.ndim == 1 and p == 1 and given.size == steps:
        given = given[:, None, None]
    if given.ndim < 3:
        return as_covariance(given, "R", p)[None]
    if given.shape != (steps, p, p):
        raise ShapeError("{name} must be {size}×{size}, or one such matrix a sample; its shape is {array_shape}.",
                         name="R", size=p, array_shape=given.shape)
    each = np.array([as_covariance(one, "R", p) for one in given]) if p > 1 else given
    if p == 1 and (given < 0).any():
        raise EngineError("{name} has a negative eigenvalue; it must be positive semidefinite.", name="R")
    return each


def _levels(gate: object, steps: int) -> np.ndarray:
    levels = as_numbers(gate, "gate").reshape(-1)
    if levels.size not in (1, steps):
        raise ShapeError("{name} must have {length} entries; it has {vector_size}.", name="gate", length=steps, vector_size=levels.size)
    if (levels <= 0).any() or (levels > 1).any():
        raise EngineError("A gate is the share of good readings that it lets through, above 0 and at most 1, such as 0.999.")
    return np.broadcast_to(levels, (steps,))
