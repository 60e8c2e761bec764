"""Filters for plants that are not linear: extended (first-order expansion) and unscented (sigma points)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..systems.arrays import as_covariance, symmetric
from ..systems.errors import EngineError, ShapeError
from ..systems.jacobian import columns, expand
from ..systems.noise import root
from .belief import Belief, Correction
from .kalman import gain_of, joseph
from .sigma_points import centred, check_spread, sigma_points, sigma_weights
from .track import Schedule, Track, as_record

__all__ = ["ExtendedKalmanFilter", "UnscentedKalmanFilter"]

Map = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class NonlinearFilter(ABC):
    """A filter for x[k+1] = f(x[k], u[k]) + w[k], y[k] = h(x[k], u[k]) + v[k], white w, v of covariances Q, R.

    f and h take states as columns, x (n, N) with u (m, 1), and return (n, N) and (p, N): `A @ x + B @ u` and
    `np.stack([x[1], -np.sin(x[0])])` are right as they stand, and `each_column` wraps a function of one state. Q is n×n,
    R p×p. Steps are pure; a measurement that is NaN did not arrive. Raises ShapeError, EngineError.
    """

    f: Map
    h: Map
    Q: np.ndarray
    R: np.ndarray

    def __post_init__(self) -> None:
        for name in ("Q", "R"):
            size = len(np.atleast_2d(np.asarray(getattr(self, name), dtype=float)))
            object.__setattr__(self, name, as_covariance(getattr(self, name), name, size))

    @property
    def n(self) -> int:
        """Number of states."""
        return len(self.Q)

    @property
    def p(self) -> int:
        """Number of measurements."""
        return len(self.R)

    @abstractmethod
    def predict(self, belief: Belief, u: object = ()) -> Belief:
        """The belief one step later, before its measurement. u is (m,)."""

    @abstractmethod
    def expected(self, belief: Belief, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """ŷ (p,), its covariance S (p×p) with R in it, and that of x with y (n×p)."""

    @abstractmethod
    def narrowed(self, belief: Belief, u: np.ndarray, S: np.ndarray, M: np.ndarray) -> np.ndarray:
        """P after the measurement with gain M (n×p; zero columns for sensors not seen)."""

    def correct(self, belief: Belief, y: object, u: object = ()) -> Correction:
        """The measurement y (p,) taken in: x̂ + M (y − ŷ), M = P_xy S⁻¹."""
        belief, u, y = self._fitting(belief), as_input(u), np.asarray(y, dtype=float).reshape(-1)
        if y.size != self.p:
            raise ShapeError("y must hold {p} numbers; it holds {y_size}.", p=self.p, y_size=y.size)
        expected, S, across = self.expected(belief, u)
        nu = y - expected
        if np.isinf(nu).any():
            raise EngineError("A measurement is infinite; give NaN where none arrived.")
        seen = np.isfinite(nu)
        if np.count_nonzero(seen) == seen.size:
            M = gain_of(S, across.T)
        else:
            M = np.zeros((self.n, self.p))
            if seen.any():
                M[:, seen] = gain_of(S[np.ix_(seen, seen)], across[:, seen].T)
        after = Belief(belief.mean + M @ np.where(seen, nu, 0.0), self.narrowed(belief, u, S, M))
        return Correction(after, nu, S, M)

    def update(self, belief: Belief, y: object, u: object = ()) -> Belief:
        """The belief after the measurement y (p,); `correct` also says innovation, S and gain."""
        return self.correct(belief, y, u).belief

    def run(self, start: Belief, y: object, u: object | None = None) -> Track:
        """A record y (n_t, p) with the inputs u (n_t, m) filtered; `start` is the belief before the first measurement."""
        y = as_record(y, "y", self.p)
        inputs = np.zeros((len(y), 0)) if u is None else np.asarray(u, dtype=float)
        inputs = as_record(inputs, "u", inputs.shape[1] if inputs.ndim == 2 else 1,
                           rows=len(y)) if u is not None else inputs
        prior, rows = self._fitting(start), []
        for k in range(len(y)):
            step = self.correct(prior, y[k], inputs[k])
            rows.append((prior.mean, step.belief.mean, step.innovation, prior.covariance, step.belief.covariance,
                         step.S, step.gain))
            if k + 1 < len(y):
                prior = self.predict(step.belief, inputs[k])
        predicted, means, innovations, *spreads = (np.array(part) for part in zip(*rows, strict=True))
        return Track(predicted, means, innovations, Schedule(len(y), *spreads))

    def _fitting(self, belief: Belief) -> Belief:
        if belief.mean.size != self.n:
            raise ShapeError("The belief is about {mean_size} states but Q is {n}×{n}; they must agree.",
                             mean_size=belief.mean.size, n=self.n)
        return belief


def as_input(u: object) -> np.ndarray:
    """An input (m,)."""
    return np.asarray(u, dtype=float).reshape(-1)


@dataclass(frozen=True, eq=False)
class ExtendedKalmanFilter(NonlinearFilter):
    """The Kalman filter along the expansion F = ∂f/∂x at x̂[k|k], H = ∂h/∂x at x̂[k|k−1]; see `NonlinearFilter`.

    `F(x, u)` (n×n) and `H(x, u)` (p×n) of one state x (n,) may be given; otherwise they come from a complex step,
    exact to rounding for f and h that are analytic (no |x|, no comparisons). Joseph's form. Report, appendix B.1.
    """

    F: Map | None = None
    H: Map | None = None

    def predict(self, belief: Belief, u: object = ()) -> Belief:
        """x̂[k+1|k] = f(x̂, u), P[k+1|k] = F P Fᵀ + Q."""
        belief, u = self._fitting(belief), as_input(u)
        mean, F = expand(self.f, self.F, belief.mean, u, "f", self.n)
        return Belief(mean, symmetric(F @ belief.covariance @ F.T + self.Q))

    def expected(self, belief: Belief, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """h(x̂, u), H P Hᵀ + R, P Hᵀ."""
        y, H = expand(self.h, self.H, belief.mean, u, "h", self.p)
        across = belief.covariance @ H.T
        return y, symmetric(H @ across) + self.R, across

    def narrowed(self, belief: Belief, u: np.ndarray, S: np.ndarray, M: np.ndarray) -> np.ndarray:
        """(I − M H) P (I − M H)ᵀ + M R Mᵀ."""
        return joseph(belief.covariance, expand(self.h, self.H, belief.mean, u, "h", self.p)[1], self.R, M)


@dataclass(frozen=True, eq=False)
class UnscentedKalmanFilter(NonlinearFilter):
    """2n + 1 sigma points through f and h instead of derivatives; see `NonlinearFilter`.

    Points x̂ and x̂ ± √(n+λ) column of the Cholesky factor of P, λ = α²(n+κ) − n; weights λ/(n+λ) and 1/(2(n+λ)), the
    first one + 1 − α² + β for covariances. The points for the measurement are drawn anew from P[k+1|k], Q included:
    without that (Algorithm 3 as printed) it is not the Kalman filter on a linear plant. With α = 1, κ = 0 every weight
    is ≥ 0, so that P stays positive; α below 0.1 is refused, its weights of n/α² only magnify rounding.
    Julier and Uhlmann (1997); report, appendix B.2.
    """

    alpha: float = 1.0
    beta: float = 2.0
    kappa: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check_spread(self.n, self.alpha, self.beta, self.kappa)

    @cached_property
    def weights(self) -> tuple[float, np.ndarray, np.ndarray]:
        """√(n+λ), the weights of means and of covariances (2n + 1,)."""
        return sigma_weights(self.n, self.alpha, self.beta, self.kappa)

    def points(self, belief: Belief) -> np.ndarray:
        """The sigma points as columns, n × (2n + 1)."""
        try:
            factor = np.linalg.cholesky(belief.covariance)
        except np.linalg.LinAlgError:  # semidefinite
            factor = root(belief.covariance)
        return sigma_points(belief.mean, self.weights[0] * factor)

    def predict(self, belief: Belief, u: object = ()) -> Belief:
        """Mean and covariance of f over the sigma points, plus Q."""
        later = columns(self.f, self.points(self._fitting(belief)), as_input(u), "f", self.n)
        mean, away = centred(later, self.weights[1])
        return Belief(mean, symmetric((away * self.weights[2]) @ away.T) + self.Q)

    def expected(self, belief: Belief, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """ŷ, S, P_xy over sigma points drawn from the belief."""
        return self._expected(self.points(belief), belief.mean, u)

    def narrowed(self, belief: Belief, u: np.ndarray, S: np.ndarray, M: np.ndarray) -> np.ndarray:
        """P − M S Mᵀ."""
        return symmetric(belief.covariance - M @ S @ M.T)

    def step_without_redraw(self, belief: Belief, y: object, u: object = (), u_next: object = ()) -> Belief:
        """Predict by u, then take in y (with u_next in h), the points for h not drawn anew: Algorithm 3 as printed.

        For comparison only: Q is missing from P_xy and from the spread in S.
        """
        later = columns(self.f, self.points(self._fitting(belief)), as_input(u), "f", self.n)
        prior = self.predict(belief, u)
        expected, S, across = self._expected(later, prior.mean, as_input(u_next))
        M = gain_of(S, across.T)
        nu = np.asarray(y, dtype=float).reshape(-1) - expected
        return Belief(prior.mean + M @ nu, self.narrowed(prior, as_input(u_next), S, M))

    def _expected(self, points: np.ndarray, middle: np.ndarray,
                  u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        y, away = centred(columns(self.h, points, u, "h", self.p), self.weights[1])
        weighted = (away * self.weights[2]).T
        return y, symmetric(away @ weighted) + self.R, (points - middle[:, None]) @ weighted
