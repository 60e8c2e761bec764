"""Filter by first-order expansion: along the estimate (EKF), or once about a rest point."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ...systems.arrays import symmetric
from ...systems.errors import ShapeError
from ...systems.flow import Flow
from ...systems.gates.argument_checks import FUNCTION, matrix, optional, passed, vector
from ...systems.jacobian import Map, slopes
from ...systems.records import record
from ..belief import Belief, Beliefs
from ..linear.kalman import ahead, joseph
from .nonlinear_filter import Expected, NonlinearFilter

__all__ = ["ExtendedKalmanFilter", "LinearisedFilter"]

Expansion = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@record()
class ExtendedKalmanFilter(NonlinearFilter):
    """The Kalman filter along the expansion F = ∂f/∂x at x̂[k|k], H = ∂h/∂x at x̂[k|k−1]; see `NonlinearFilter`.

    `f_expand` and `h_expand` map columns x (n, N), u to values (·, N) and slopes (N, ·, n). Left out, a `Flow` gives its
    own, and any other map is differentiated by a complex step, exact to rounding for maps that are analytic (no |x|, no
    comparisons). Joseph's form. Report, appendix B.1.

    >>> ekf = ExtendedKalmanFilter(lambda x, u: np.sin(x), lambda x, u: x, np.eye(1), np.eye(1))
    >>> ekf.update(ekf.predict(Belief([0], [[1]])), [3.0]).mean
    array([2.])
    """

    f_expand: Expansion | None = None
    h_expand: Expansion | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        passed(self, f_expand=optional(FUNCTION), h_expand=optional(FUNCTION))
        if self.f_expand is None and isinstance(self.f, Flow):
            object.__setattr__(self, "f_expand", self.f.expand)

    def ahead(self, belief: Belief | Beliefs, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, None]:
        """x̂[k+1|k] = f(x̂, u), P[k+1|k] = F P Fᵀ + Q."""
        mean, F = self._expanded(belief, self.f, self.f_expand, u, "f", self.n)
        return mean, ahead(F, self.Q, belief.covariance), None

    def along(self, beliefs: Beliefs, mean: np.ndarray, F: np.ndarray) -> Beliefs:
        """The beliefs one step later from f(x̂, u) (n, N) and its slopes F (N, n, n)."""
        return Beliefs(mean, ahead(F, self.Q, beliefs.covariance))

    def expected(self, belief: Belief | Beliefs, u: np.ndarray) -> Expected:
        """h(x̂, u), H P Hᵀ + R, P Hᵀ."""
        mean, H = self._expanded(belief, self.h, self.h_expand, u, "h", self.p)
        return _expected(mean, H, self.R, belief.covariance)

    def _expanded(self, belief: Belief | Beliefs, f: Map, expand: Expansion | None, u: np.ndarray, name: str,
                  rows: int) -> tuple[np.ndarray, np.ndarray]:
        x = belief.mean.reshape(self.n, -1)
        values, J = slopes(f, x, u, name=name, rows=rows) if expand is None else expand(x, u)
        if len(values) != rows or J.shape[-2:] != (rows, self.n):
            raise ShapeError("The Jacobian of {name} must be {rows}×{x_size}; its shape is {slope_shape}.",
                             name=name, rows=rows, x_size=self.n, slope_shape=J.shape[-2:])
        return (values[:, 0], J[0]) if isinstance(belief, Belief) else (values, J)


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

    def expected(self, belief: Belief | Beliefs, u: np.ndarray) -> Expected:
        """The one gain for all runs."""
        *_, h0, C, D, x, rest = self.expanded
        mean = h0 + C @ (belief.mean.reshape(self.n, -1) - x) + D @ (u - rest)
        P = _shared(belief)
        return _expected(mean[:, 0] if isinstance(belief, Belief) else mean, C, self.R, P)


def _shared(belief: Belief | Beliefs) -> np.ndarray:
    return belief.covariance if isinstance(belief, Belief) else belief.covariance[:1]


def _expected(mean: np.ndarray, H: np.ndarray, R: np.ndarray, P: np.ndarray) -> Expected:
    """H P Hᵀ + R, P Hᵀ and Joseph's form."""
    across = P @ H.swapaxes(-1, -2)
    return Expected(mean, symmetric(H @ across) + R, across, lambda M: joseph(P, H, R, M))
