"""The same filter on many runs at once: linear, extended and unscented, every step one batch of small matrices."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..systems.arrays import as_covariance
from ..systems.errors import EngineError, ShapeError, phrase
from ..systems.flow import Flow, slopes
from .sigma_points import centred, check_spread, sigma_points, sigma_weights

__all__ = ["Beliefs", "Corrections", "ExtendedFilters", "LinearFilters", "ManyFilters", "PrintedUnscentedFilters",
           "UnscentedFilters"]

Map = Callable[[np.ndarray, np.ndarray], np.ndarray]
Expansion = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
LEAST = 1e-12  # of an eigenvalue of a correlation matrix whose Cholesky factor does not exist


@dataclass(frozen=True, eq=False)
class Beliefs:
    """A Gaussian belief in each of N runs: means (n, N), covariances (N, n, n) or (1, n, n) where all share one.

    `points` (n, 2n + 1, N) are sigma points carried on instead of being drawn anew, by `PrintedUnscentedFilters` alone.
    """

    mean: np.ndarray
    covariance: np.ndarray
    points: np.ndarray | None = None

    @classmethod
    def alike(cls, mean: object, covariance: object, runs: int) -> Beliefs:
        """The same belief, mean (n,) and covariance (n×n), in every run."""
        mean = np.asarray(mean, dtype=float)
        P = as_covariance(covariance, phrase("The covariance"), mean.size)
        return cls(np.repeat(mean[:, None], runs, axis=1), np.repeat(P[None], runs, axis=0))


@dataclass(frozen=True, eq=False)
class Corrections:
    """One measurement taken in by every run: beliefs after it, innovations (p, N), their covariances S (N, p, p)."""

    beliefs: Beliefs
    innovation: np.ndarray
    S: np.ndarray


@dataclass(frozen=True, eq=False)
class ManyFilters(ABC):
    """N filters side by side for x[k+1] = f(x[k], u[k]) + w[k], y[k] = h(x[k], u[k]) + v[k], covariances Q (n×n) and R (p×p).

    f and h take columns, x (n, N) and u (m, N) or (m, 1), and return (n, N) and (p, N), as in `NonlinearFilter`; a `Flow`
    is such an f. Steps are pure. Raises ShapeError, EngineError.
    """

    f: Map
    h: Map
    Q: np.ndarray
    R: np.ndarray

    def __post_init__(self) -> None:
        for name in ("Q", "R"):
            matrix = np.atleast_2d(np.asarray(getattr(self, name), dtype=float))
            object.__setattr__(self, name, as_covariance(matrix, name, len(matrix)))

    @abstractmethod
    def predict(self, beliefs: Beliefs, u: np.ndarray) -> Beliefs:
        """The beliefs one step later, before their measurements."""

    @abstractmethod
    def correct(self, beliefs: Beliefs, y: np.ndarray, u: np.ndarray) -> Corrections:
        """The measurements y (p, N) taken in: x̂ + M (y − ŷ), M = P_xy S⁻¹."""

    def wanted(self, beliefs: Beliefs) -> np.ndarray | None:
        """Points (n, s, N) whose images under f are all that `predicted` needs; None where `predict` needs more."""
        return None

    def predicted(self, beliefs: Beliefs, images: np.ndarray) -> Beliefs:
        """The beliefs one step later from the images (n, s, N) of the points wanted."""
        raise EngineError("{name} needs more than the images of points; call predict.", name=type(self).__name__)

    def _fitting(self, beliefs: Beliefs) -> Beliefs:
        if len(beliefs.mean) != len(self.Q):
            raise ShapeError("The beliefs are about {count} states but Q is {count2}×{count2}; they must agree.",
                             count=len(beliefs.mean), count2=len(self.Q))
        return beliefs

    def _innovation(self, y: np.ndarray, expected: np.ndarray) -> np.ndarray:
        if y.shape != expected.shape or len(y) != len(self.R):
            raise ShapeError("y must be {rows}×{columns}, a row for each output of h and a column for each run; "
                             "it is {y_shape}, and R is for {count} outputs.",
                             rows=expected.shape[0], columns=expected.shape[1], y_shape=y.shape, count=len(self.R))
        return y - expected


def gains(S: np.ndarray, across: np.ndarray) -> np.ndarray:
    """M = P_xy S⁻¹ (N, n, p) from S (N, p, p) and P_xy (N, n, p)."""
    if S.shape[-1] == 1:
        return across / S
    try:
        return np.linalg.solve(S, across.swapaxes(-1, -2)).swapaxes(-1, -2)
    except np.linalg.LinAlgError:  # a filter gone astray: R is lost beside H P Hᵀ
        return across @ np.linalg.pinv(np.nan_to_num(S))


def even(P: np.ndarray) -> np.ndarray:
    """(P + Pᵀ)/2 of each matrix."""
    return (P + P.swapaxes(-1, -2)) / 2


@dataclass(frozen=True, eq=False)
class ExtendedFilters(ManyFilters):
    """Extended Kalman filters: F = ∂f/∂x at x̂[k|k], H = ∂h/∂x at x̂[k|k−1], Joseph's form.

    `f_expand` and `h_expand` return value and slopes (N, ·, n); without them a `Flow` is asked for its own and any other
    map is differentiated by a complex step. Report, appendix B.1.
    """

    f_expand: Expansion | None = None
    h_expand: Expansion | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.f_expand is None and isinstance(self.f, Flow):
            object.__setattr__(self, "f_expand", self.f.expand)

    def predict(self, beliefs: Beliefs, u: np.ndarray) -> Beliefs:
        """x̂[k+1|k] = f(x̂, u), P[k+1|k] = F P Fᵀ + Q."""
        x = self._fitting(beliefs).mean
        mean, F = slopes(self.f, x, u) if self.f_expand is None else self.f_expand(x, u)
        return self.along(beliefs, mean, F)

    def along(self, beliefs: Beliefs, mean: np.ndarray, F: np.ndarray) -> Beliefs:
        """The beliefs one step later from f(x̂, u) (n, N) and its slopes F (N, n, n)."""
        return Beliefs(mean, even(F @ beliefs.covariance @ F.swapaxes(1, 2)) + self.Q)

    def correct(self, beliefs: Beliefs, y: np.ndarray, u: np.ndarray) -> Corrections:
        """ŷ = h(x̂, u), S = H P Hᵀ + R, P_xy = P Hᵀ."""
        expected, H = slopes(self.h, beliefs.mean, u) if self.h_expand is None else self.h_expand(beliefs.mean, u)
        return expanded_correction(beliefs, self._innovation(y, expected), H, self.R)


def expanded_correction(beliefs: Beliefs, nu: np.ndarray, H: np.ndarray, R: np.ndarray) -> Corrections:
    """The update along slopes H (N, p, n) with innovations ν (p, N)."""
    P = beliefs.covariance
    across = P @ H.swapaxes(-1, -2)
    S = even(H @ across) + R
    M = gains(S, across)
    keep = np.eye(len(beliefs.mean)) - M @ H
    after = even(keep @ P @ keep.swapaxes(-1, -2) + M @ R @ M.swapaxes(-1, -2))
    return Corrections(Beliefs(beliefs.mean + moved(M, nu), after), nu, S)


def moved(M: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """M ν of each run as columns (n, N), M (N or 1, n, p), ν (p, N)."""
    if len(M) == 1:
        return M[0] @ nu
    return (M @ nu.T[:, :, None])[:, :, 0].T


@dataclass(frozen=True, eq=False)
class LinearFilters(ManyFilters):
    """Kalman filters of the plant expanded once, about x_rest (n,) and u_rest (m,): all runs share one covariance.

    x̂[k+1|k] = f₀ + A (x̂ − x_rest) + B (u − u_rest), ŷ = h₀ + C (x̂ − x_rest) + D (u − u_rest).
    """

    x_rest: np.ndarray
    u_rest: np.ndarray

    @cached_property
    def expanded(self) -> tuple[np.ndarray, ...]:
        """f₀ (n, 1), A, B, h₀ (p, 1), C, D, all by a complex step."""
        x, u = (np.asarray(v, dtype=float)[:, None] for v in (self.x_rest, self.u_rest))
        f0, A = slopes(self.f, x, u)
        h0, C = slopes(self.h, x, u)
        B, D = (np.zeros((rows, 0)) if not len(u) else slopes(lambda v, _, f=f: f(x + 0 * v[:1], v), u, x)[1][0]
                for f, rows in ((self.f, len(x)), (self.h, len(h0))))
        return f0, A[0], B, h0, C[0], D, x, u

    def predict(self, beliefs: Beliefs, u: np.ndarray) -> Beliefs:
        """A P Aᵀ + Q, whatever was measured."""
        f0, A, B, *_, x, rest = self.expanded
        mean = f0 + A @ (beliefs.mean - x) + B @ (u - rest)
        return Beliefs(mean, even(A @ beliefs.covariance[:1] @ A.T) + self.Q)

    def correct(self, beliefs: Beliefs, y: np.ndarray, u: np.ndarray) -> Corrections:
        """The one gain for all runs."""
        *_, h0, C, D, x, rest = self.expanded
        shared = replace(beliefs, covariance=beliefs.covariance[:1])
        return expanded_correction(shared, self._innovation(y, h0 + C @ (beliefs.mean - x) + D @ (u - rest)), C[None], self.R)


@dataclass(frozen=True, eq=False)
class UnscentedFilters(ManyFilters):
    """Unscented filters: 2n + 1 sigma points a run, weights as in `UnscentedKalmanFilter`, drawn anew before h.

    Where a covariance has lost its Cholesky factor, its correlation eigenvalues are raised to 1e-12 for the points. Julier
    and Uhlmann (1997); report, appendix B.2. Raises EngineError for α outside [0.1, 1] or κ ≤ −n.
    """

    alpha: float = 1.0
    beta: float = 2.0
    kappa: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check_spread(len(self.Q), self.alpha, self.beta, self.kappa)

    @cached_property
    def weights(self) -> tuple[float, np.ndarray, np.ndarray]:
        """√(n+λ), the weights of means and of covariances (2n + 1,)."""
        return sigma_weights(len(self.Q), self.alpha, self.beta, self.kappa)

    def points(self, beliefs: Beliefs) -> np.ndarray:
        """The sigma points of each run, (n, 2n + 1, N)."""
        return sigma_points(beliefs.mean, self.weights[0] * roots(beliefs.covariance).transpose(1, 2, 0))

    def predict(self, beliefs: Beliefs, u: np.ndarray) -> Beliefs:
        """Mean and covariance of f over the sigma points, plus Q."""
        return self.predicted(beliefs, through(self.f, self.wanted(beliefs), u))

    def wanted(self, beliefs: Beliefs) -> np.ndarray:
        """The sigma points."""
        return self.points(self._fitting(beliefs))

    def predicted(self, beliefs: Beliefs, images: np.ndarray) -> Beliefs:
        """Weighted mean and covariance of the images, plus Q."""
        return replace(self._carried(images), points=None)

    def correct(self, beliefs: Beliefs, y: np.ndarray, u: np.ndarray) -> Corrections:
        """ŷ, S, P_xy over the sigma points; P − M S Mᵀ."""
        points = self.points(self._fitting(beliefs)) if beliefs.points is None else beliefs.points
        expected, away = centred(through(self.h, points, u), self.weights[1])
        nu = self._innovation(y, expected)
        weighted = (away * self.weights[2][:, None]).transpose(2, 1, 0)
        S = even(away.transpose(2, 0, 1) @ weighted) + self.R
        across = (points - beliefs.mean[:, None, :]).transpose(2, 0, 1) @ weighted
        M = gains(S, across)
        after = even(beliefs.covariance - M @ S @ M.swapaxes(1, 2))
        return Corrections(Beliefs(beliefs.mean + moved(M, nu), after), nu, S)

    def _carried(self, later: np.ndarray) -> Beliefs:
        mean, away = centred(later, self.weights[1])
        spread = (away * self.weights[2][:, None]).transpose(2, 0, 1) @ away.transpose(2, 1, 0)
        return Beliefs(mean, even(spread) + self.Q, later)


@dataclass(frozen=True, eq=False)
class PrintedUnscentedFilters(UnscentedFilters):
    """Algorithm 3 of the report as printed: the points that f has moved serve h too, so Q is missing from P_xy and S.

    For comparison only: on a linear plant this is not the Kalman filter.
    """

    def predicted(self, beliefs: Beliefs, images: np.ndarray) -> Beliefs:
        """As `UnscentedFilters`, the moved points kept."""
        return self._carried(images)


def through(f: Map, points: np.ndarray, u: np.ndarray) -> np.ndarray:
    """A map over points (n, s, N), u (m, N) or (m, 1): (·, s, N)."""
    n, s, N = points.shape
    each = np.tile(u, (1, s)) if u.shape[1] == N and N > 1 else u
    return f(points.reshape(n, s * N), each).reshape(-1, s, N)


def roots(P: np.ndarray) -> np.ndarray:
    """Factors U (N, n, n) with U Uᵀ = P: Cholesky's, or from eigenvalues of the correlations kept above 1e-12."""
    try:
        return np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        spread = np.sqrt(np.maximum(np.diagonal(P, axis1=1, axis2=2), 1e-300))
        scale = spread[:, :, None] * spread[:, None, :]
        values, vectors = np.linalg.eigh(np.nan_to_num(P / scale))
        factors = spread[:, :, None] * (vectors * np.sqrt(np.maximum(values, LEAST))[:, None, :])
        whole = (values[:, 0] > LEAST) & np.isfinite(P).all(axis=(1, 2))  # these have Cholesky's, whatever befalls the others
        factors[whole] = np.linalg.cholesky(P[whole])
        return factors
