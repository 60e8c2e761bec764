"""Compute χ² alarm thresholds for residuals over a window, and their detection probability."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri, chndtr, chndtrinc

from ..systems.errors import EngineError, ShapeError, phrase
from ..systems.gates.argument_checks import LEVEL, SHARE, array, count, number, takes

__all__ = ["alarm_probability", "binomial_band", "needed_noncentrality", "residual_threshold", "window_energy", "window_mean"]


@takes(residual=array(missing=True), window=count(1))
def window_energy(residual: object, window: int) -> np.ndarray:
    """Σ ‖ρ‖² over the last `window` samples, (n_t − window + 1, …): χ²(q·window) for white ρ of unit covariance.

    ρ is (n_t, …, q); entry k is of the window that ends with sample k + window − 1. Any fault adds to it. Raises ShapeError.
    """
    rho = _record(residual, window)
    return _sums((rho**2).sum(axis=-1), window)


@takes(residual=array(missing=True), window=count(1))
def window_mean(residual: object, window: int) -> np.ndarray:
    """‖Σ ρ‖²/window over the last `window` samples, (n_t − window + 1, …): χ²(q) for white ρ of unit covariance.

    Shapes as `window_energy`. A fault whose effect keeps its sign adds as much to it as to the energy, whose noise is
    larger; one that changes sign within the window cancels. Raises ShapeError.
    """
    rho = _record(residual, window)
    return (_sums(rho, window)**2).sum(axis=-1) / window


def _sums(values: np.ndarray, window: int) -> np.ndarray:
    """Sums of `window` successive values, (n_t − window + 1, …), each made of its own values alone.

    In blocks as long as a window: what is left of one block and the beginning of the next. A running total would keep the
    rounding of a large fault, or a NaN, for ever.
    """
    count, rest = len(values) - window + 1, values.shape[1:]
    padded = np.zeros((-(-len(values) // window), window, *rest))
    padded.reshape(-1, *rest)[:len(values)] = values
    begun = np.cumsum(padded, axis=1).reshape(-1, *rest)[window - 1:][:count].copy()
    left = np.cumsum(padded[:, ::-1], axis=1)[:, ::-1].reshape(-1, *rest)[:count]
    across = np.arange(count) % window > 0
    begun[across] += left[across]
    return begun


@takes(dof=number(0, 1_000_000.0), false_alarm=SHARE)
def residual_threshold(dof: float, false_alarm: float) -> float:
    """The value that χ²(dof) passes with probability `false_alarm`, the chosen false-alarm rate of one window.

    Raises EngineError for a rate outside (0, 1) or no degree of freedom.
    """
    _check(dof, false_alarm, phrase("The false-alarm rate"))
    return float(chdtri(dof, false_alarm))


@takes(noncentrality=array(), dof=number(0, 1_000_000.0), false_alarm=SHARE)
def alarm_probability(noncentrality: object, dof: float, false_alarm: float) -> np.ndarray:
    """With what probability the threshold is passed when a fault adds `noncentrality`: noncentral χ²(dof, λ).

    λ is what the statistic would be without noise. Raises EngineError.

    >>> np.round(alarm_probability([0.0, 10.0, 100.0], 1, 0.01), 3)
    array([0.01 , 0.721, 1.   ])
    """
    lam = np.asarray(noncentrality, dtype=float)
    if not np.all(lam >= 0):
        raise EngineError("A noncentrality is a sum of squares and cannot be negative.")
    threshold = residual_threshold(dof, false_alarm)
    passed = np.clip(1.0 - chndtr(threshold, dof, np.minimum(lam, 1e6)), 0.0, 1.0)
    return np.where(lam == 0, false_alarm, np.where(lam > 1e5 + 4 * threshold, 1.0, passed))


@takes(dof=number(0, 1_000_000.0), false_alarm=SHARE, power=SHARE)
def needed_noncentrality(dof: float, false_alarm: float, power: float) -> float:
    """The least λ with which the threshold is passed with probability `power`. Raises EngineError unless power > rate."""
    threshold = residual_threshold(dof, false_alarm)
    _check(dof, power, phrase("The power"))
    if power <= false_alarm:
        raise EngineError("The power must be larger than the false-alarm rate; without a fault it is that rate.")
    return float(chndtrinc(threshold, dof, 1.0 - power))


@takes(count=count(1, 10 ** 9), rate=SHARE, level=LEVEL)
def binomial_band(count: int, rate: float, *, level: float = 0.99) -> tuple[float, float]:
    """Where the share of `count` independent windows that give an alarm lies with at least probability `level`.

    Raises EngineError for fewer than one window, or a rate or level outside (0, 1).
    """
    _check(1, rate, phrase("The rate"))
    _check(1, level, phrase("The level"))
    from scipy.stats import binom  # late: 0.6 s

    low, high = binom.ppf([(1 - level) / 2, (1 + level) / 2], count, rate)
    return float(low / count), float(high / count)


def _check(dof: float, share: float, name: str) -> None:
    if not dof > 0:
        raise EngineError("A χ² statistic needs at least one degree of freedom.")
    if not 0 < share < 1:
        raise EngineError("{name} must lie between 0 and 1, for example 0.01.", name=name)


def _record(residual: object, window: int) -> np.ndarray:
    rho = np.asarray(residual, dtype=float)
    if rho.ndim < 2 or not 1 <= window <= len(rho):
        raise ShapeError("A residual must be (n_t, …, q) with at least one window of {window} samples; it is "
                         "{rho_shape}.",
                         window=window, rho_shape=rho.shape)
    return rho
