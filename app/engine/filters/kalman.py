"""The Kalman filter: Joseph's form, and beside it the short form that lessons compare it with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv  # pyright: ignore[reportAttributeAccessIssue]

from ..systems.arrays import symmetric
from ..systems.errors import EngineError
from .belief import Belief
from .linear_filter import LinearFilter

__all__ = ["KalmanFilter", "gain_of", "joseph", "short_form"]

def gain(P: np.ndarray, C: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """S = C P Cᵀ + R (p×p) and M = P Cᵀ S⁻¹ (n×p). Raises EngineError where S is singular."""
    CP = C @ P
    S = CP @ C.T + R
    return S, gain_of(S, CP)


def gain_of(S: np.ndarray, across: np.ndarray) -> np.ndarray:
    """M = P_xy S⁻¹ (n×p) from S (p×p) and P_yx (p×n), by Cholesky, or by elimination where rounding spoilt S.

    Raises EngineError where S is singular.
    """
    _, solution, failure = dposv(S, across)
    if failure:
        try:
            solution = np.linalg.solve(S, across)
        except np.linalg.LinAlgError as problem:
            raise EngineError("The covariance S of the innovation is singular: give every sensor some noise R, or use the "
                              "square-root filter.") from problem
    return solution.T


def joseph(P: np.ndarray, C: np.ndarray, R: np.ndarray, M: np.ndarray) -> np.ndarray:
    """(I − M C) P (I − M C)ᵀ + M R Mᵀ, symmetric: right for any gain M, positive semidefinite whatever the rounding."""
    keep = -(M @ C)
    keep.reshape(-1)[::len(P) + 1] += 1.0
    return symmetric(keep @ P @ keep.T + M @ R @ M.T)


def short_form(P: np.ndarray, C: np.ndarray, M: np.ndarray) -> np.ndarray:
    """(I − M C) P: right for the optimal gain in exact arithmetic only; neither symmetric nor safely positive."""
    return P - M @ (C @ P)


@dataclass(frozen=True, eq=False)
class KalmanFilter(LinearFilter):
    """The Kalman filter with Joseph's covariance update, symmetric after every step; see `LinearFilter`.

    Report on the platform, equations (53)–(59). Where R is many orders below C P Cᵀ and sensors nearly agree, use
    `SquareRootFilter`.
    """

    def spread(self, belief: Belief) -> np.ndarray:
        """P itself."""
        return belief.covariance

    def belief(self, mean: np.ndarray, spread: np.ndarray) -> Belief:
        """Mean and P."""
        return Belief(mean, spread)

    def covariance(self, spread: np.ndarray) -> np.ndarray:
        """P itself."""
        return spread

    def forward(self, spread: np.ndarray) -> np.ndarray:
        """A P Aᵀ + Q."""
        return symmetric(self.A @ spread @ self.A.T + self.Q)

    def corrected(self, spread: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """S, M and P after the measurement by the sensors that were `seen`."""
        if np.count_nonzero(seen) == len(seen):
            S, M = gain(spread, self.C, self.R)
            return S, M, joseph(spread, self.C, self.R, M)
        M = np.zeros((self.n, len(seen)))
        S = symmetric(self.C @ spread @ self.C.T) + self.R
        if not seen.any():
            return S, M, spread
        C, R = self.C[seen], self.R[np.ix_(seen, seen)]
        M[:, seen] = gain(spread, C, R)[1]
        return S, M, joseph(spread, C, R, M[:, seen])

    def short_update(self, belief: Belief, y: object, u: object | None = None) -> Belief:
        """`update` by the short form P − M C P, for comparison: it drifts and may lose positivity (Algorithm 1)."""
        step = self.correct(belief, y, u)
        return Belief(step.belief.mean, short_form(belief.covariance, self.C, step.gain))

