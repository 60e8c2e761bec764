"""Compute the 2n + 1 sigma points of unscented filters, in one run or in many."""

from __future__ import annotations

import numpy as np

from ...systems.errors import EngineError
from ...systems.gates.argument_checks import count, number, takes
from .differences import Combine, minus, plus

SMALLEST_ALPHA = 0.1
MIN_EIGENVALUE = 1e-12  # of an eigenvalue of a correlation matrix whose Cholesky factor does not exist


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
