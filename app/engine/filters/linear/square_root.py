"""Run the square-root Kalman filter: carry U with P = U Uᵀ by orthogonal steps."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from ...kernels.recursion import root_steps
from ...systems.errors import EngineError
from ...systems.noise import root
from ...systems.records import record
from ..belief import Belief, RootBelief
from .compiled_schedule import Goal, quick_schedule
from .linear_filter import LOOK_EVERY, LinearFilter
from .timed_runs import Source as Source  # as in kalman.py

__all__ = ["SquareRootFilter"]


def lower(wide: np.ndarray) -> np.ndarray:
    """The lower triangular L with L Lᵀ = M Mᵀ for a wide M, by QR of Mᵀ: the product itself is never formed."""
    return np.asarray(np.linalg.qr(wide.T, mode="r")).T


@record()
class SquareRootFilter(LinearFilter):
    """The Kalman filter in roots of its covariances; see `LinearFilter`. Beliefs are `RootBelief`.

    Measurement: [R^½ C U; 0 U] Θ = [S^½ 0; K̄ U⁺] with Θ orthogonal, M = K̄ S^{−½}; time: [A U Q^½] Θ = [U⁺ 0]. S is
    never formed, so R may be 1e-18 of C P Cᵀ while sensors nearly agree, where P − M C P and Joseph's form both fail.
    Array algorithms after Morf and Kailath (1975).

    >>> kf = SquareRootFilter([[1]], [[0]], [[1]], 1.0, 1.0)
    >>> np.round(kf.run(Belief([0], [[1]]), [1.0, 1.0, 1.0]).means[:, 0], 4)
    array([0.5   , 0.8   , 0.9231])
    """

    @cached_property
    def noise_roots(self) -> tuple[np.ndarray, np.ndarray]:
        """Q^½ (n×n) and R^½ (p×p)."""
        return root(self.Q), root(self.R)

    def spread(self, belief: Belief) -> np.ndarray:
        """U, from the belief itself or from its covariance."""
        return belief.root if isinstance(belief, RootBelief) else root(belief.covariance)

    def belief(self, mean: np.ndarray, spread: np.ndarray) -> RootBelief:
        """Mean, U and P = U Uᵀ."""
        return RootBelief.of(mean, spread)

    def covariance(self, spread: np.ndarray) -> np.ndarray:
        """U Uᵀ."""
        return spread @ spread.T

    def quickly(self, sizes: tuple[int, int, int], spread: np.ndarray, seen: np.ndarray | None,
                goal: Goal) -> tuple[np.ndarray, ...] | None:
        """As `LinearFilter`, in roots."""
        fixed = self.A, self.C, self.noise_roots[0], self.R, self.noise_roots[1]
        return quick_schedule(root_steps, fixed, spread, sizes, seen, goal, LOOK_EVERY)

    def forward(self, spread: np.ndarray, *, A: np.ndarray | None = None, Q: np.ndarray | None = None) -> np.ndarray:
        """The root of A U Uᵀ Aᵀ + Q."""
        return lower(np.hstack([(self.A if A is None else A) @ spread, self.noise_roots[0] if Q is None else root(Q)]))

    def corrected(self, spread: np.ndarray, seen: np.ndarray, *, R: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """S, M and U after the measurement by the sensors that were `seen`."""
        p, n = self.C.shape
        CU, R_root, R = self.C @ spread, self.noise_roots[1] if R is None else root(R), self.R if R is None else R
        S, M = CU @ CU.T + R, np.zeros((n, p))
        count = int(seen.sum())
        if count == 0:
            return S, M, spread
        if count < p:
            R_root = root(R[np.ix_(seen, seen)])
        rows = np.zeros((count + n, count + n))
        rows[:count, :count] = R_root
        rows[:count, count:] = CU[seen]
        rows[count:, count:] = spread
        triangle = lower(rows)
        S_root = triangle[:count, :count]
        if not np.all(np.abs(np.diag(S_root)) > 0):
            raise EngineError("Two sensors without noise measure the same: give every sensor some noise R.")
        M[:, seen] = solve_triangular(S_root, triangle[count:, :count].T, lower=True, trans=1).T
        return S, M, triangle[count:, count:]
