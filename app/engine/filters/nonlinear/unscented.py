"""Filter by 2n + 1 sigma points through f and h instead of derivatives (UKF)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...systems.arrays import symmetric
from ...systems.errors import EngineError
from ...systems.gates.argument_checks import count, number, passed, takes
from ...systems.jacobian import Map as Map  # the inherited fields name it, and the API pages look for it here
from ...systems.records import record
from ..belief import Belief, Beliefs
from .differences import Combine as Combine  # as Map: the inherited fields name it, and the API pages look for it here
from .differences import minus, plus
from .nonlinear_filter import Expected, NonlinearFilter

__all__ = [
    "MIN_EIGENVALUE",
    "SMALLEST_ALPHA",
    "PrintedUnscentedFilter",
    "UnscentedKalmanFilter",
    "centred",
    "check_spread",
    "roots",
    "sigma_points",
    "sigma_weights",
]

SMALLEST_ALPHA = 0.1
MIN_EIGENVALUE = 1e-12  # of an eigenvalue of a correlation matrix whose Cholesky factor does not exist


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


def check_spread(n: int, alpha: float, beta: float, kappa: float) -> None:
    """Raises EngineError for α outside [0.1, 1], κ ≤ −n, or a number that is not finite."""
    if not SMALLEST_ALPHA <= alpha <= 1:
        raise EngineError("α must lie between {smallest_alpha} and 1; smaller ones give weights that only magnify "
                          "rounding.",
                          smallest_alpha=SMALLEST_ALPHA)
    if not (np.isfinite(beta) and np.isfinite(kappa) and n + kappa > 0):
        raise EngineError("β and κ must be finite numbers, and κ larger than −n.")


@takes(n=count(1, 1000), alpha=number(high=1_000_000.0, above=0), beta=number(), kappa=number())
def sigma_weights(n: int, alpha: float, beta: float, kappa: float) -> tuple[float, np.ndarray, np.ndarray]:
    """√(n+λ) and the weights of means and of covariances (2n + 1,), λ = α²(n+κ) − n."""
    reach = alpha**2 * (n + kappa)
    if not reach > 0:
        raise EngineError("β and κ must be finite numbers, and κ larger than −n.")
    mean = np.full(2 * n + 1, 0.5 / reach)
    mean[0] = 1 - n / reach
    covariance = mean.copy()
    covariance[0] += 1 - alpha**2 + beta
    return float(np.sqrt(reach)), mean, covariance


def sigma_points(mean: np.ndarray, factor: np.ndarray) -> np.ndarray:
    """x̂ and x̂ ± each column of the factor, (n, 2n + 1, …): mean (n, …), factor (n, n, …)."""
    n, middle = len(mean), mean[:, None]
    points = np.empty((n, 2 * n + 1, *mean.shape[1:]))
    points[:, :1] = middle
    np.add(middle, factor, out=points[:, 1:n + 1])
    np.subtract(middle, factor, out=points[:, n + 1:])
    return points


def centred(values: np.ndarray, weights: np.ndarray, apart: Combine | None = None,
            together: Combine | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Weighted mean (·, …) of values (·, 2n + 1, …), and the values without it.

    The mean is taken about the first value, against cancellation; `apart` and `together` stand for − and +.
    """
    first = values[:, :1]
    mean = plus(together, first[:, 0], np.moveaxis(minus(apart, values, first), 1, -1) @ weights)
    return mean, minus(apart, values, mean[:, None])


def roots(P: np.ndarray) -> np.ndarray:
    """Factors U (…, n, n) with U Uᵀ = P: Cholesky's, or from eigenvalues of the correlations kept above 1e-12."""
    try:
        return np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        spread = np.sqrt(np.maximum(np.diagonal(P, axis1=-2, axis2=-1), 1e-300))
        scale = spread[..., :, None] * spread[..., None, :]
        values, vectors = np.linalg.eigh(np.nan_to_num(P / scale))
        factors = spread[..., :, None] * (vectors * np.sqrt(np.maximum(values, MIN_EIGENVALUE))[..., None, :])
        whole = (values[..., 0] > MIN_EIGENVALUE) & np.isfinite(P).all(axis=(-2, -1))  # whatever befalls the others
        if P.ndim > 2:
            factors[whole] = np.linalg.cholesky(P[whole])
        return factors
