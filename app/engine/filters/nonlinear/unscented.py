"""Filter by 2n + 1 sigma points through f and h instead of derivatives (UKF)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...systems.arrays import symmetric
from ...systems.gates.argument_checks import number, passed
from ...systems.jacobian import Map as Map  # the inherited fields name it, and the API pages look for it here
from ...systems.records import record
from ..belief import Belief, Beliefs
from .differences import Combine as Combine  # as Map: the inherited fields name it, and the API pages look for it here
from .differences import minus, plus
from .nonlinear_filter import Expected, NonlinearFilter
from .sigma_points import centred, check_spread, roots, sigma_points, sigma_weights

__all__ = ["PrintedUnscentedFilter", "UnscentedKalmanFilter"]


@record()
class UnscentedKalmanFilter(NonlinearFilter):
    """2n + 1 sigma points through f and h instead of derivatives; see `NonlinearFilter`.

    Points x̂ and x̂ ± √(n+λ) column of the Cholesky factor of P, λ = α²(n+κ) − n; weights λ/(n+λ) and 1/(2(n+λ)), the
    first one + 1 − α² + β for covariances. The points for the measurement are drawn anew from P[k+1|k], Q included:
    without that (Algorithm 3 as printed) it is not the Kalman filter on a linear plant. With α = 1, κ = 0 every weight
    is ≥ 0, so that P stays positive; α below 0.1 is refused, its weights of n/α² only magnify rounding. Where P has lost
    its Cholesky factor, its correlation eigenvalues are raised to 1e-12 for the points.
    Julier and Uhlmann (1997); report, appendix B.2.

    >>> ukf = UnscentedKalmanFilter(lambda x, u: x**2, lambda x, u: x, np.eye(1), np.eye(1))
    >>> ukf.predict(Belief([1], [[1]])).mean.round(12)  # m² + P
    array([2.])
    """

    alpha: float = 1.0
    beta: float = 2.0
    kappa: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        passed(self, alpha=number(), beta=number(), kappa=number())
        check_spread(self.n, self.alpha, self.beta, self.kappa)

    @cached_property
    def weights(self) -> tuple[float, np.ndarray, np.ndarray]:
        """√(n+λ), the weights of means and of covariances (2n + 1,)."""
        return sigma_weights(self.n, self.alpha, self.beta, self.kappa)

    def points(self, belief: Belief | Beliefs) -> np.ndarray:
        """The sigma points as columns, (n, 2n + 1), or of each run (n, 2n + 1, N)."""
        factor = roots(belief.covariance)
        factor = self.weights[0] * (factor if factor.ndim == 2 else factor.transpose(1, 2, 0))
        if self.x_plus is None:
            return sigma_points(belief.mean, factor)
        middle = np.zeros_like(sigma_points(belief.mean, factor)) + belief.mean[:, None]
        return plus(self.x_plus, middle, sigma_points(np.zeros_like(belief.mean), factor))

    def ahead(self, belief: Belief | Beliefs, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Mean and covariance of f over the sigma points, plus Q."""
        return *self._moments(self.through(self.f, self.points(belief), u, "f", self.n)), None

    def wanted(self, beliefs: Beliefs) -> np.ndarray:
        """The sigma points."""
        return self.points(beliefs)

    def predicted(self, beliefs: Beliefs, images: np.ndarray) -> Beliefs:
        """Weighted mean and covariance of the images, plus Q."""
        return Beliefs(*self._moments(images))

    def lead(self, belief: Belief, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mean and covariance of f over the sigma points, and how x goes with it."""
        points = self.points(belief)
        mean, away = centred(self.through(self.f, points, u, "f", self.n), self.weights[1], self.x_minus, self.x_plus)
        weighted = self._weighted(away)
        return mean, symmetric(away @ weighted), minus(self.x_minus, points, belief.mean[:, None]) @ weighted

    def expected(self, belief: Belief | Beliefs, u: np.ndarray, *, R: np.ndarray | None = None) -> Expected:
        """ŷ, S, P_xy over the sigma points; P − M S Mᵀ."""
        carried = belief.points if isinstance(belief, Beliefs) else None
        points = self.points(belief) if carried is None else carried
        mean, away = centred(self.through(self.h, points, u, "h", self.p), self.weights[1], self.y_minus)
        weighted = self._weighted(away)
        S = symmetric(_runs_first(away) @ weighted) + (self.R if R is None else R)
        across = _runs_first(minus(self.x_minus, points, belief.mean[:, None])) @ weighted
        return Expected(mean, S, across, lambda M: symmetric(belief.covariance - M @ S @ M.swapaxes(-1, -2)))

    def _moments(self, images: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        mean, away = centred(images, self.weights[1], self.x_minus, self.x_plus)
        return mean, symmetric(_runs_first(away) @ self._weighted(away)) + self.Q

    def _weighted(self, away: np.ndarray) -> np.ndarray:
        """The deviations times their weights, transposed: (2n + 1, ·) or (N, 2n + 1, ·)."""
        return (away.T if away.ndim == 2 else away.transpose(2, 1, 0)) * self.weights[2][:, None]


@record()
class PrintedUnscentedFilter(UnscentedKalmanFilter):
    """Algorithm 3 of the report as printed: the points that f has moved serve h too, so Q is missing from P_xy and S.

    For comparison only, on `Beliefs`: on a linear plant this is not the Kalman filter.
    """

    def ahead(self, belief: Belief | Beliefs, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As `UnscentedKalmanFilter`, the moved points kept."""
        images = self.through(self.f, self.points(belief), u, "f", self.n)
        return *self._moments(images), images

    def predicted(self, beliefs: Beliefs, images: np.ndarray) -> Beliefs:
        """As `UnscentedKalmanFilter`, the moved points kept."""
        return Beliefs(*self._moments(images), images)


def _runs_first(points: np.ndarray) -> np.ndarray:
    """(·, s) as it is, (·, s, N) as (N, ·, s)."""
    return points if points.ndim == 2 else points.transpose(2, 0, 1)
