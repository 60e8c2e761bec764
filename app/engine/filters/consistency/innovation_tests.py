"""Test the innovations of a filter: mean, whiteness and size against its covariances."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc, ndtri

from ...systems.errors import EngineError, phrase
from ...systems.gates.argument_checks import LEVEL, RECORD, array, count, takes
from ...systems.records import record
from .squared_error import SquaredError, chi2_band, covariances_of, nis, record_of, squared

__all__ = ["InnovationTest", "Whiteness", "innovation_test", "whiteness"]

CONSTANT_CHANNEL_RTOL = 1e-14  # of the largest value: a channel that varies less is constant


@record()
class Whiteness:
    """Autocorrelation of the innovations at lags 1 … `lags`, and portmanteau tests of its being zero.

    correlation (lags, p), each within ±band with probability `level` if white. outside: share of it that is not.
    statistics, p_values (p,): Ljung–Box of each channel, N (N + 2) Σ r_l²/(N − l), χ² with `lags` degrees of freedom.
    joint, p_value: Hosking's multivariate form, which sees correlation between channels too, χ² with p²·lags.
    """

    correlation: np.ndarray
    band: float
    outside: float
    statistics: np.ndarray
    p_values: np.ndarray
    joint: float
    p_value: float
    level: float

    @property
    def white(self) -> bool:
        """Whether the joint test lets the record pass."""
        return self.p_value >= 1 - self.level


@record()
class InnovationTest:
    """Mean, whiteness and size of the innovations.

    mean (p,); scores (p,): mean in units of its standard deviation √(S/N); bias: N ν̄ᵀS̄⁻¹ν̄ and bias_p_value, χ²(p).
    failures: of "biased", "coloured", "overconfident", "cautious", those that hold, each of the three tests at a third
    of 1 − level, so that a tuned filter passes with probability `level`.
    """

    mean: np.ndarray
    scores: np.ndarray
    bias: float
    bias_p_value: float
    whiteness: Whiteness
    nis: SquaredError
    level: float
    failures: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether no test failed."""
        return not self.failures


@takes(innovations=RECORD, lags=count(1, 10_000), level=LEVEL)
def whiteness(innovations: object, *, lags: int = 20, level: float = 0.95) -> Whiteness:
    """Whether innovations (n_t, p) are white: r_l within ±z/√N, Ljung and Box (1978), Hosking (1980).

    Q = N² Σ_l (N − l)⁻¹ tr(C_lᵀ C₀⁻¹ C_l C₀⁻¹) with C_l = (1/N) Σ ν_k ν_{k−l}ᵀ about the mean. Raises EngineError for
    records shorter than twice the lags or with NaN, or channels that are constant or copies of each other.
    """
    nu = record_of(innovations, phrase("The innovations"))
    N, p = nu.shape
    if lags > N // 2:
        raise EngineError("With {n} samples the lags must be between 1 and {n2}.", n=N, n2=N // 2)
    if not np.isfinite(nu).all():
        raise EngineError("A test of whiteness needs every sample; the innovations hold NaN.")
    chi2_band(1, count=1, level=level)
    away = nu - nu.mean(axis=0)
    spread = np.sqrt((away**2).mean(axis=0))
    if not (spread > CONSTANT_CHANNEL_RTOL * np.abs(nu).max(axis=0)).all():
        raise EngineError("A channel of the innovations is constant; leave it out of the test.")
    away = away / spread
    C0 = away.T @ away / N
    C = np.stack([away[lag:].T @ away[:N - lag] / N for lag in range(1, lags + 1)])
    correlation = np.diagonal(C, axis1=1, axis2=2).copy()
    weight = N**2 / (N - np.arange(1, lags + 1))
    statistics = (N + 2) / N * (weight @ correlation**2)
    if np.linalg.eigvalsh(C0)[0] < 1e-10:
        raise EngineError("Two channels of the innovations are copies of each other; leave one out of the test.")
    left = np.linalg.solve(C0, np.swapaxes(C, 1, 2))  # C₀⁻¹ C_lᵀ
    right = np.linalg.solve(C0, C)
    joint = float(weight @ np.einsum("lij,lji->l", left, right))
    band = float(ndtri((1 + level) / 2) / np.sqrt(N))
    return Whiteness(correlation, band, float((np.abs(correlation) > band).mean()), statistics,
                     chdtrc(lags, statistics), joint, float(chdtrc(p * p * lags, joint)), level)


@takes(innovations=RECORD, S=array(), lags=count(1, 10_000), level=LEVEL)
def innovation_test(innovations: object, S: object, *, lags: int = 20, level: float = 0.95) -> InnovationTest:
    """Are innovations (n_t, p) what a filter with covariances S (p×p or n_t×p×p) promises: centred, white, of size S?

    Leave the transient of a wrongly started filter out first. Raises as `nis` and `whiteness` do.

    >>> nu = np.random.default_rng(0).standard_normal((500, 1))
    >>> innovation_test(nu, np.eye(1)).passed
    True
    """
    nu = record_of(innovations, phrase("The innovations"))
    N, p = nu.shape
    covariances = covariances_of(S, nu.shape, "S")
    S_bar = covariances.mean(axis=0) if covariances.ndim == 3 else covariances
    third = 1 - (1 - level) / 3
    white, size, mean = whiteness(nu, lags=lags, level=third), nis(nu, covariances, level=third), nu.mean(axis=0)
    bias = float(N * squared(mean[None], S_bar, "S")[0])
    bias_p_value = float(chdtrc(p, bias))
    failures = (("biased",) if bias_p_value < 1 - third else ()) + (() if white.white else ("coloured",))
    if size.verdict != "consistent":
        failures += (size.verdict,)
    return InnovationTest(mean, mean / np.sqrt(np.diag(S_bar) / N), bias, bias_p_value, white, size, level, failures)
