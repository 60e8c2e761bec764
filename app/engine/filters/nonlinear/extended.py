"""Filter by first-order expansion: along the estimate (EKF), or once about a rest point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, replace
from functools import cached_property

import numpy as np

from ...systems.arrays import symmetric
from ...systems.errors import EngineError, ShapeError
from ...systems.flow import Flow, NonlinearPlant
from ...systems.gates.argument_checks import FUNCTION, SECONDS, array, count, instance, matrix, optional, passed, takes, vector
from ...systems.gates.map_roles import InTime, roles_of
from ...systems.jacobian import Map, central_slopes, complex_step_fits, slopes, slopes_known
from ...systems.records import record
from ..belief import Belief, Beliefs
from ..linear.kalman import ahead, gain_of, joseph
from .differences import Combine as Combine  # as Map: the inherited fields name it, and the API pages look for it here
from .differences import minus, plus
from .nonlinear_filter import Expected, NonlinearFilter, answered, moved_by

__all__ = ["ExtendedKalmanFilter", "LinearisedFilter", "slopes_along"]

SETTLED = 1e-13  # of the mean: a further expansion changes it by less
Expansion = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@record()
class ExtendedKalmanFilter(NonlinearFilter):
    """The Kalman filter along the expansion F = ∂f/∂x at x̂[k|k], H = ∂h/∂x at x̂[k|k−1]; see `NonlinearFilter`.

    `f_expand` and `h_expand` map columns x (n, N), u to values (·, N) and slopes (N, ·, n). Left out, a `Flow` gives its
    own. Any other map is differentiated by a complex step, exact to rounding for maps that are analytic; where that does not agree
    with central differences (|x|, `np.interp`), these are taken. Joseph's form. With `iterations` > 1 h is expanded again about the
    corrected mean, so often at most (iterated EKF): Gauss–Newton steps to the most likely state. Report, appendix B.1; Bell and
    Cathey (1993).

    >>> ekf = ExtendedKalmanFilter(lambda x, u: np.sin(x), lambda x, u: x, np.eye(1), np.eye(1))
    >>> ekf.update(ekf.predict(Belief([0], [[1]])), [3.0]).mean
    array([2.])
    """

    f_expand: Expansion | None = None
    h_expand: Expansion | None = None
    iterations: int = field(default=1, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        passed(self, f_expand=optional(FUNCTION), h_expand=optional(FUNCTION), iterations=count(1, 1000))
        if self.f_expand is None and isinstance(self.f, Flow):
            object.__setattr__(self, "f_expand", self.f.expand)

    def ahead(self, belief: Belief | Beliefs, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, None]:
        """x̂[k+1|k] = f(x̂, u), P[k+1|k] = F P Fᵀ + Q."""
        mean, F = self._expanded(belief, self.f, self.f_expand, u, "f", self.n)
        return mean, ahead(F, self.Q, belief.covariance), None

    def along(self, beliefs: Beliefs, mean: np.ndarray, F: np.ndarray) -> Beliefs:
        """The beliefs one step later from f(x̂, u) (n, N) and its slopes F (N, n, n)."""
        return Beliefs(mean, ahead(F, self.Q, beliefs.covariance))

    def lead(self, belief: Belief, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """f(x̂, u), F P Fᵀ, P Fᵀ."""
        mean, F = self._expanded(belief, self.f, self.f_expand, u, "f", self.n)
        across = belief.covariance.dot(F.T)
        return mean, symmetric(F.dot(across)), across

    def expected(self, belief: Belief | Beliefs, u: np.ndarray, *, R: np.ndarray | None = None) -> Expected:
        """h(x̂, u), H P Hᵀ + R, P Hᵀ."""
        mean, H = self._expanded(belief, self.h, self.h_expand, u, "h", self.p)
        return _expected(mean, H, self.R if R is None else R, belief.covariance)

    def taken_in(self, belief: Belief | Beliefs, y: np.ndarray, u: np.ndarray, *,
                 R: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
        """ν, S, M, mean and covariance after the measurement y; ν and S of the first expansion, M and the rest of the last."""
        nu, S, M, mean, P = super().taken_in(belief, y, u, R=R)
        for _ in range(self.iterations - 1):
            there = belief.bare(mean, belief.covariance) if isinstance(belief, Belief) else replace(belief, mean=mean)
            expected = self.expected(there, u, R=R)
            assert expected.H is not None
            back = minus(self.x_minus, belief.mean, mean)
            moved = expected.H @ back if isinstance(belief, Belief) else np.einsum("...pn,n...->p...", expected.H, back)
            away = minus(self.y_minus, y, expected.mean) - moved
            missing = np.isnan(y)
            M = gain_of(*answered(expected.S, expected.across, ~missing))
            before, mean = mean, plus(self.x_plus, belief.mean, moved_by(M, np.where(missing, 0.0, away)))
            P = expected.after(M)
            if np.all(np.abs(mean - before) <= SETTLED * np.maximum(np.abs(mean), np.abs(back))):
                break
        return nu, S, M, mean, P

    def maps_in_time(self) -> dict[str, object]:
        """As `NonlinearFilter`, with the slopes."""
        maps = super().maps_in_time()
        if isinstance(self.f, Flow):
            maps["f_expand"] = maps["f"].expand  # type: ignore[attr-defined]
        elif self.f_expand is not None:
            maps["f_expand"] = InTime(self.f_expand, roles_of(self.f_expand))
        return maps if self.h_expand is None else {**maps, "h_expand": InTime(self.h_expand, roles_of(self.h_expand))}

    def _expanded(self, belief: Belief | Beliefs, f: Map, expand: Expansion | None, u: np.ndarray, name: str,
                  rows: int) -> tuple[np.ndarray, np.ndarray]:
        single, x = isinstance(belief, Belief), belief.mean
        x = x[:, None] if single else x
        values, J = self._slopes(belief, f, x, u, name, rows) if expand is None else expand(x, u)
        if len(values) != rows or J.shape[-2:] != (rows, len(x)):
            raise ShapeError("The Jacobian of {name} must be {rows}×{x_size}; its shape is {slope_shape}.",
                             name=name, rows=rows, x_size=self.n, slope_shape=J.shape[-2:])
        return (values[:, 0], J[0]) if single else (values, J)

    def _slopes(self, belief: Belief | Beliefs, f: Map, x: np.ndarray, u: np.ndarray, name: str,
                rows: int) -> tuple[np.ndarray, np.ndarray]:
        """By the complex step where it agrees with differences, which is looked at once; else by differences."""
        if self._complex_steps.get(name):
            return slopes_known(f, x, u, name, rows)
        spread = np.sqrt(np.maximum(np.diagonal(belief.covariance.reshape(-1, self.n, self.n)[0]), 0.0))
        if name not in self._complex_steps:
            self._complex_steps[name] = complex_step_fits(f, x[:, 0], u, spread, name=name, rows=rows)
            return self._slopes(belief, f, x, u, name, rows)
        return central_slopes(f, x, u, spread, name=name, rows=rows)

    @cached_property
    def _complex_steps(self) -> dict[str, bool]:
        """Of f and h, whether a complex step differentiates them."""
        return {}


@record()
class LinearisedFilter(NonlinearFilter):
    """The Kalman filter of the plant expanded once, about x_rest (n,) and u_rest (m,): all runs share one covariance.

    x̂[k+1|k] = f₀ + A (x̂ − x_rest) + B (u − u_rest), ŷ = h₀ + C (x̂ − x_rest) + D (u − u_rest).
    """

    x_rest: np.ndarray
    u_rest: np.ndarray

    def __post_init__(self) -> None:
        super().__post_init__()
        passed(self, Q=matrix("n n"), x_rest=vector("n"), u_rest=vector())

    @cached_property
    def expanded(self) -> tuple[np.ndarray, ...]:
        """f₀ (n, 1), A, B, h₀ (p, 1), C, D, x_rest (n, 1), u_rest (m, 1), all slopes by a complex step."""
        x, u = (np.asarray(v, dtype=float).reshape(-1, 1) for v in (self.x_rest, self.u_rest))
        f0, A = slopes(self.f, x, u, name="f", rows=self.n)
        h0, C = slopes(self.h, x, u, name="h", rows=self.p)
        B, D = (np.zeros((rows, 0)) if not len(u) else slopes(lambda v, _, f=f: f(x + 0 * v[:1], v), u, x)[1][0]
                for f, rows in ((self.f, len(x)), (self.h, len(h0))))
        return f0, A[0], B, h0, C[0], D, x, u

    def ahead(self, belief: Belief | Beliefs, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, None]:
        """A P Aᵀ + Q, whatever was measured."""
        f0, A, B, *_, x, rest = self.expanded
        mean = f0 + A @ (belief.mean.reshape(self.n, -1) - x) + B @ (u - rest)
        return mean.reshape(belief.mean.shape), ahead(A, self.Q, _shared(belief)), None

    def lead(self, belief: Belief, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The expansion's step, A P Aᵀ, P Aᵀ."""
        f0, A, B, *_, x, rest = self.expanded
        mean, across = f0 + A @ (belief.mean[:, None] - x) + B @ (u - rest), belief.covariance @ A.T
        return mean[:, 0], symmetric(A @ across), across

    def expected(self, belief: Belief | Beliefs, u: np.ndarray, *, R: np.ndarray | None = None) -> Expected:
        """The one gain for all runs."""
        *_, h0, C, D, x, rest = self.expanded
        mean = h0 + C @ (belief.mean.reshape(self.n, -1) - x) + D @ (u - rest)
        P = _shared(belief)
        return _expected(mean[:, 0] if isinstance(belief, Belief) else mean, C, self.R if R is None else R, P)

    def maps_in_time(self) -> dict[str, object]:
        """The plant expanded once makes steps of one length. Raises EngineError."""
        raise EngineError("A filter that is linearised once makes steps of one length; leave t out, or use ExtendedKalmanFilter.")


def _shared(belief: Belief | Beliefs) -> np.ndarray:
    return belief.covariance if isinstance(belief, Belief) else belief.covariance[:1]


def _expected(mean: np.ndarray, H: np.ndarray, R: np.ndarray, P: np.ndarray) -> Expected:
    """H P Hᵀ + R, P Hᵀ and Joseph's form."""
    if P.ndim == H.ndim == 2:
        across = P.dot(H.T)
        S = H.dot(across)
    else:
        across = P @ H.swapaxes(-1, -2)
        S = H @ across
    return Expected(mean, (symmetric(S) if S.shape[-1] > 1 else S) + R, across, lambda M: joseph(P, H, R, M), H)


@takes(plant=instance(NonlinearPlant), step=SECONDS, x=array("n k"), u=array("m l"), parts=count(1, 100_000))
def slopes_along(plant: NonlinearPlant, step: float, x: np.ndarray, u: np.ndarray, *, parts: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """∂f/∂x (k, n, n) of a plant's flow over `step` s in so many parts, and ∂y/∂x (k, p, n), at states (n, k) and inputs (m, k).

    x[k+1] = f(x[k], u[k]); the derivative of the discrete map itself. u may have one column for all. Raises ShapeError.
    """
    if len(x) != plant.n or len(u) != plant.m or u.shape[1] not in (1, x.shape[1]):
        raise ShapeError("The plant has {n} states and {m} inputs: x needs {n} rows, u {m}, and a column for each state or one for all.",
                         n=plant.n, m=plant.m)
    return plant.flow(step, parts=parts).expand(x, u)[1], plant.output_slope(x, u)
