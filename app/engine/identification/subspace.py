"""Fit A and C by subspace identification, with the order and the spread of the poles."""

from __future__ import annotations

from dataclasses import field

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import linear_sum_assignment

from ..systems.errors import EngineError
from ..systems.gates.argument_checks import array, count, optional, takes
from ..systems.records import record as a_record
from .windows import Factors, factors_of, triangle_of

__all__ = ["MAX_ORDER", "Subspace", "noise_edge", "order_by_information", "order_of", "subspace"]

MAX_ORDER = 10
SHORTEST, LONGEST, ROWS_PER_STEP = 5, 15, 30  # steps of past and future, and rows that pay for one
MARGIN = 1.15  # on the largest singular value that noise alone gives


@a_record()
class Subspace:
    """A and C of a fitted plant, in coordinates in which its states are as large as each other.

    singular_values: canonical correlations between past and future, each from 0 to 1. edge: the largest that noise alone would
    give in a record of this length. suggested: how many lie above it. poles (n,) of A, sorted by (real, imag). deviations (n,):
    standard deviation of each pole, |z − ẑ|. spread (n, 2, 2): covariance of its real and imaginary part.
    horizon: steps of past and of future that were used. by_information: the order with the least information criterion.
    intervals (n, 2): the 95 % interval of each real pole where `identify` gives one, NaN for a pair.
    """

    A: np.ndarray
    C: np.ndarray
    singular_values: np.ndarray
    edge: float
    suggested: int
    poles: np.ndarray
    deviations: np.ndarray
    spread: np.ndarray
    horizon: int
    by_information: int = 0
    intervals: np.ndarray = field(default=None)  # type: ignore[assignment]  # always an array after construction

    def __post_init__(self) -> None:
        if self.intervals is None:
            object.__setattr__(self, "intervals", np.full((len(self.poles), 2), np.nan))


@takes(u=array("k m"), y=array("k p", missing=True), order=optional(count(1, MAX_ORDER)), horizon=optional(count(2, 100)))
def subspace(u: np.ndarray, y: np.ndarray, *, order: int | None = None, horizon: int | None = None) -> Subspace:
    """A and C by canonical variate analysis in the PO-MOESP form; `order` None takes what the singular values suggest.

    With L of [u_f; z_p; y_f] = L Q: W⁻¹ L₃₂ = U S Vᵀ, W Wᵀ = L₃₂ L₃₂ᵀ + L₃₃ L₃₃ᵀ; Γ = W U_n S_n^½, C its first rows, Γ↓ A = Γ↑.
    u (n_t, m), y (n_t, p) about their means, NaN in y where missing. The spread comes from leaving out one block of rows after the
    other (jackknife); `identify` gives that of records which the fitted model makes. Sources: Verhaegen, Automatica 30 (1994) 61–74;
    Larimore, American Control Conference (1983) 445–451; Efron, The Jackknife (1982). Raises EngineError for records that are too
    short or inputs that do not excite.
    """
    m, p = u.shape[1], y.shape[1]
    if horizon is None:
        horizon = int(np.clip(len(y) // (ROWS_PER_STEP * (m + p)), SHORTEST, LONGEST))
        horizon = max(horizon, 2 if order is None else order // p + 2)
    sizes = _sizes(u), _sizes(y)
    factors = factors_of(u / sizes[0], y / sizes[1], horizon, horizon)
    W, left, values = _decomposed(factors.whole(), factors)
    edge = noise_edge(*factors.sizes[1:], factors.count)
    most = min(MAX_ORDER, (horizon - 1) * p, len(values))
    suggested = min(order_of(values, edge), most)
    n = suggested if order is None else order
    if not 1 <= n <= most:
        raise EngineError("The order must be from 1 to {most} for this record; it is {order}.", most=most, order=n)
    A, C = _model(W, left, values, n, p)
    poles = np.sort_complex(np.linalg.eigvals(A))
    spread = _jackknife(factors, n, poles)
    deviations = np.sqrt(np.trace(spread, axis1=1, axis2=2))
    return Subspace(A, sizes[1][:, None] * C, values, edge, suggested, poles, deviations, spread, horizon,
                    min(order_by_information(values, m, p, factors.count), most))


def noise_edge(a: int, b: int, count: int) -> float:
    """The largest canonical correlation that `count` independent rows of a and of b unrelated columns give, times a margin of 1.15.

    √λ with λ = (√(α(1 − β)) + √(β(1 − α)))², α = a/count, β = b/count. Source: Wachter, Annals of Statistics 8 (1980) 937–957.
    """
    alpha, beta = min(a / count, 0.5), min(b / count, 0.5)
    return float(min(MARGIN * (np.sqrt(alpha * (1 - beta)) + np.sqrt(beta * (1 - alpha))), 1.0))


def order_of(values: np.ndarray, edge: float) -> int:
    """How many singular values stand above the edge of noise: at least 1, at most 10."""
    above = int(np.count_nonzero(values > edge))
    return int(np.clip(above, 1, MAX_ORDER))


def order_by_information(values: np.ndarray, m: int, p: int, count: int) -> int:
    """The order n ≥ 1 with the least σ²_{n+1} + n (2p + m) log(N)/N.

    Source: Bauer, Automatica 37 (2001) 1561–1573.
    """
    orders = np.arange(1, min(MAX_ORDER, len(values)) + 1)
    left = np.append(values, 0.0)[orders] ** 2
    return int(orders[np.argmin(left + orders * (2 * p + m) * np.log(count) / count)])


def _sizes(columns: np.ndarray) -> np.ndarray:
    """Root mean square of each column, 1 for one that is zero."""
    size = np.sqrt(np.nanmean(columns**2, axis=0)) if columns.shape[1] else np.ones(0)
    return np.where(size > 0, size, 1.0)


def _decomposed(L: np.ndarray, factors: Factors) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """W, U and the canonical correlations of a lower factor."""
    first, second, _ = factors.sizes
    L32, L33 = L[first + second:, first:first + second], L[first + second:, first + second:]
    both = triangle_of(np.hstack([L32, L33]).T).T
    both = both * np.where(np.diag(both) < 0, -1.0, 1.0)
    size = np.abs(np.diag(both))
    floor = 1e-12 * size.max()
    both[np.diag_indices_from(both)] = np.maximum(size, floor)  # without noise nothing is left that the past does not tell
    U, values, _ = np.linalg.svd(solve_triangular(both, L32, lower=True), full_matrices=False)
    return both, U, np.minimum(values, 1.0)


def _model(W: np.ndarray, U: np.ndarray, values: np.ndarray, n: int, p: int) -> tuple[np.ndarray, np.ndarray]:
    """A and C from the extended observability matrix Γ."""
    Gamma = W @ (U[:, :n] * np.sqrt(values[:n]))
    return np.linalg.lstsq(Gamma[:-p], Gamma[p:], rcond=None)[0], Gamma[:p]


def _jackknife(factors: Factors, n: int, poles: np.ndarray) -> np.ndarray:
    """Covariance of real and imaginary part of each pole (n, 2, 2): (J − 1)/J Σ (z_j − z̄)² over the records without block j."""
    found = []
    for L in factors.left_out():
        A, _ = _model(*_decomposed(L, factors), n, factors.p)
        other = np.linalg.eigvals(A)
        _, order = linear_sum_assignment(np.abs(poles[:, None] - other))
        found.append(other[order])
    away = np.array(found) - np.mean(found, axis=0)
    parts = np.stack([away.real, away.imag], axis=-1)
    return (len(found) - 1) / len(found) * np.einsum("jni,jnk->nik", parts, parts)
