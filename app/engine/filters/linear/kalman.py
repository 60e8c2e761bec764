"""Compute Kalman prediction and correction: Joseph's form and the short form."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.linalg.lapack import dposv  # pyright: ignore[reportAttributeAccessIssue]

from ...kernels.recursion import joseph_steps
from ...systems.arrays import frozen, symmetric
from ...systems.errors import EngineError
from ...systems.gates.argument_checks import BOOLEAN, array, choice, count, matrix, optional, takes, vector
from ...systems.records import record
from ..belief import Belief
from .compiled_schedule import Goal, quick_schedule
from .linear_filter import LOOK_EVERY, LinearFilter
from .timed_runs import Source as Source  # the inherited fields name it, and the API pages look for it here

__all__ = ["FORMS", "KalmanFilter", "ahead", "correct", "gain_of", "joseph", "posterior_covariances", "predict", "short_form"]

FORMS = ("joseph", "short")


@takes(A=matrix("n n"), Q=matrix("n n"), mean=vector("n"), P=matrix("n n"))
def predict(A: np.ndarray, Q: np.ndarray, mean: np.ndarray, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The belief N(x̂, P) about x one step later, about A x + w with w ~ N(0, Q): mean (n,) and covariance n×n.

    A x + w − A x̂ = A e + w with e = x − x̂ and w independent, so E x⁺ = A x̂ and P⁺ = E (A e + w)(A e + w)ᵀ = A P Aᵀ + Q.

    >>> predict(np.array([[2.0]]), np.eye(1), np.array([1.0]), np.eye(1))
    (array([2.]), array([[5.]]))
    """
    return A @ mean, ahead(A, Q, P)


@takes(C=matrix("p n"), R=matrix("p p"), mean=vector("n"), P=matrix("n n"), y=vector("p"))
def correct(C: np.ndarray, R: np.ndarray, mean: np.ndarray, P: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The belief N(x̂, P) after y = C x + v, v ~ N(0, R), is heard: mean (n,) and covariance n×n.

    (x, y) is Gaussian with cov(x, y) = P Cᵀ and var y = S = C P Cᵀ + R, so E(x | y) = x̂ + M (y − C x̂) with M = P Cᵀ S⁻¹,
    and what is left, x − E(x | y) = (I − M C) e − M v, has the covariance (I − M C) P (I − M C)ᵀ + M R Mᵀ.

    >>> correct(np.eye(1), np.eye(1), np.array([0.0]), np.eye(1), np.array([2.0]))
    (array([1.]), array([[0.5]]))
    """
    _, M = gain(P, C, R)
    return mean + M @ (y - C @ mean), joseph(P, C, R, M)


def ahead(A: np.ndarray, Q: np.ndarray, P: np.ndarray) -> np.ndarray:
    """A P Aᵀ + Q, symmetric; A and P may be stacks (…, n, n)."""
    return symmetric(A @ P @ A.swapaxes(-1, -2)) + Q


def gain(P: np.ndarray, C: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """S = C P Cᵀ + R (p×p) and M = P Cᵀ S⁻¹ (n×p). Raises EngineError where S is singular."""
    across = P @ C.T
    S = symmetric(C @ across) + R
    return S, gain_of(S, across)


def gain_of(S: np.ndarray, across: np.ndarray) -> np.ndarray:
    """M = P_xy S⁻¹ from S (…, p, p) and P_xy (…, n, p), by Cholesky, or by elimination where rounding spoilt S.

    Raises EngineError where a single S is singular; in a stack its run has gone astray and takes the pseudo-inverse.
    """
    if S.ndim == 2:
        if len(S) == 1 and S[0, 0] > 0:
            return across / S
        _, solution, failure = dposv(S, across.T)
        if not failure:
            return solution.T
    elif S.shape[-1] == 1:
        return across / S
    try:
        return np.linalg.solve(S, across.swapaxes(-1, -2)).swapaxes(-1, -2)
    except np.linalg.LinAlgError as problem:
        if S.ndim > 2:
            return across @ np.linalg.pinv(np.nan_to_num(S))
        raise EngineError("The covariance S of the innovation is singular: give every sensor some noise R, or use the "
                          "square-root filter.") from problem


@takes(P=array("… n n", single=True), C=array("… p n", single=True), R=array("… p p", single=True), M=array("… n p", single=True))
def joseph(P: np.ndarray, C: np.ndarray, R: np.ndarray, M: np.ndarray) -> np.ndarray:
    """(I − M C) P (I − M C)ᵀ + M R Mᵀ, symmetric: right for any gain M, positive semidefinite whatever the rounding.

    P (…, n, n), C (…, p, n) and M (…, n, p) may be stacks. Computed in the precision given.
    """
    if P.ndim == M.ndim == C.ndim == R.ndim == 2:  # of small matrices `dot` takes half the time
        keep = _one(len(P), P.dtype) - M.dot(C)
        return symmetric(keep.dot(P).dot(keep.T) + M.dot(R).dot(M.T))
    keep = _one(P.shape[-1], P.dtype) - M @ C
    return symmetric(keep @ P @ keep.swapaxes(-1, -2) + M @ R @ M.swapaxes(-1, -2))


@lru_cache(maxsize=64)
def _one(n: int, dtype: np.dtype) -> np.ndarray:
    return frozen(np.eye(n, dtype=dtype))


@takes(P=array("… n n", single=True), C=array("… p n", single=True), M=array("… n p", single=True))
def short_form(P: np.ndarray, C: np.ndarray, M: np.ndarray) -> np.ndarray:
    """(I − M C) P: right for the optimal gain in exact arithmetic only; neither symmetric nor safely positive."""
    return P - M @ (C @ P)


@record()
class KalmanFilter(LinearFilter):
    """The Kalman filter with Joseph's covariance update, symmetric after every step; see `LinearFilter`.

    Report on the platform, equations (53)–(59). Where R is many orders below C P Cᵀ and sensors nearly agree, use
    `SquareRootFilter`.

    >>> kf = KalmanFilter([[1]], [[0]], [[1]], 1.0, 1.0)
    >>> np.round(kf.run(Belief([0], [[1]]), [1.0, 1.0, 1.0]).means[:, 0], 4)
    array([0.5   , 0.8   , 0.9231])
    """

    def spread(self, belief: Belief) -> np.ndarray:
        """P itself."""
        return belief.covariance

    def belief(self, mean: np.ndarray, spread: np.ndarray) -> Belief:
        """Mean and P."""
        return Belief.computed(mean, spread)

    def covariance(self, spread: np.ndarray) -> np.ndarray:
        """P itself."""
        return spread

    def quickly(self, sizes: tuple[int, int, int], spread: np.ndarray, seen: np.ndarray | None,
                goal: Goal) -> tuple[np.ndarray, ...] | None:
        """As `LinearFilter`, in Joseph's form."""
        return quick_schedule(joseph_steps, (self.A, self.C, self.Q, self.R), spread, sizes, seen, goal, LOOK_EVERY)

    def forward(self, spread: np.ndarray, *, A: np.ndarray | None = None, Q: np.ndarray | None = None) -> np.ndarray:
        """A P Aᵀ + Q."""
        return ahead(self.A if A is None else A, self.Q if Q is None else Q, spread)

    def corrected(self, spread: np.ndarray, seen: np.ndarray, *, R: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """S, M and P after the measurement by the sensors that were `seen`."""
        R = self.R if R is None else R
        if np.count_nonzero(seen) == len(seen):
            S, M = gain(spread, self.C, R)
            return S, M, joseph(spread, self.C, R, M)
        M = np.zeros((self.n, len(seen)))
        S = symmetric(self.C @ spread @ self.C.T) + R
        if not seen.any():
            return S, M, spread
        C, R = self.C[seen], R[np.ix_(seen, seen)]
        M[:, seen] = gain(spread, C, R)[1]
        return S, M, joseph(spread, C, R, M[:, seen])

    def short_update(self, belief: Belief, y: object, u: object | None = None) -> Belief:
        """`update` by the short form P − M C P, for comparison: it drifts and may lose positivity (Algorithm 1).

        >>> KalmanFilter([[1]], [[0]], [[1]], 1.0, 1.0).short_update(Belief([0], [[1]]), [1.0]).covariance
        array([[0.5]])
        """
        step = self.correct(belief, y, u)
        return Belief.computed(step.belief.mean, short_form(belief.covariance, self.C, step.gain))


@takes(A=matrix("n n"), C=matrix("p n"), Q=matrix("n n"), R=matrix("p p"), P=matrix("n n"), steps=count(1, 1_000_000),
       form=choice(*FORMS), gain=optional(matrix("n p")), single=BOOLEAN)
def posterior_covariances(A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray, P: np.ndarray, *, steps: int = 1,
                          form: str = "joseph", gain: np.ndarray | None = None, single: bool = False) -> np.ndarray:
    """P[k|k] (steps, n, n) from P[0|−1] = P by P[k|k] = (I − M C) P[k|k−1] (…)ᵀ + M R Mᵀ, or (I − M C) P[k|k−1], and
    P[k+1|k] = A P[k|k] Aᵀ + Q, all of it in single precision if asked; report on the platform, equations (55)–(59).

    A, Q, P n×n, C p×n, R p×p in the units that the filter has. M is the optimal gain of each step or one `gain` (n×p) for
    all. What rounding leaves uneven stays so. Raises ShapeError, EngineError.

    >>> one = np.eye(1)
    >>> posterior_covariances(one, one, 0 * one, one, one, steps=3)[:, 0, 0].round(4)
    array([0.5   , 0.3333, 0.25  ])
    """
    size = np.float32 if single else np.float64
    A, C, Q, R, P = (np.asarray(M, dtype=size) for M in (A, C, Q, R, P))
    record = np.empty((steps, len(A), len(A)))
    for k in range(steps):
        M = _best(P, C, R) if gain is None else gain
        P = joseph(P, C, R, M) if form == "joseph" else short_form(P, C, M)
        record[k] = P
        P = A @ P @ A.T + Q
    return record


def _best(P: np.ndarray, C: np.ndarray, R: np.ndarray) -> np.ndarray:
    CP = C @ P
    S = CP @ C.T + R
    try:
        return np.linalg.solve(S, CP).T
    except np.linalg.LinAlgError:  # single precision may lose R beside C P Cᵀ
        return (np.linalg.pinv(S) @ CP).T
