"""Compute the mean time between false alarms of windows tested at every sample."""

from __future__ import annotations

from functools import lru_cache
from types import MappingProxyType

import numpy as np
from numpy.polynomial.polynomial import polyval
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from observer_lab.text import Text, text

from .diagnosis import ENERGY, MEAN, Rule
from .observer_bank import DT
from .run_length_table import BANK_ENERGY, BANK_MEAN, MEMBER_ENERGY, MEMBER_MEAN, WINDOWS

MEMBER = MappingProxyType({ENERGY: MEMBER_ENERGY, MEAN: MEMBER_MEAN})
BANK = MappingProxyType({ENERGY: BANK_ENERGY, MEAN: BANK_MEAN})
RATES = (1e-6, 0.1)


def member_run(test: Rule) -> float:
    """Mean number of samples, from an empty window on, until one healthy member gives a false alarm."""
    return _run(MEMBER[test.statistic], test.window, test.rate)


def bank_run(test: Rule) -> float:
    """Mean number of samples, from empty windows on, until the first of the seven healthy members gives a false alarm."""
    return _run(BANK[test.statistic], test.window, test.rate)


@lru_cache(maxsize=512)
def _run(coefficients: tuple[tuple[float, ...], ...], window: int, rate: float) -> float:
    """N − 1 samples to fill the window, then G/α: log G by a polynomial in log α for some windows, by cubics in log N between them.

    Of one member G is 1 where successive windows share nothing (N = 1). Source: a simulation, tests/benchmarks/run_lengths.py.
    """
    logs = polyval(np.log10(rate) + 3.5, np.transpose(coefficients))
    return float(window - 1 + np.exp(PchipInterpolator(np.log(WINDOWS), logs)(np.log(window))) / rate)


def seconds_between(test: Rule) -> float:
    """Mean time in s between two false alarms of the whole bank: after each the windows are emptied and fill anew."""
    return DT * bank_run(test)


@lru_cache(maxsize=64)
def rate_for(statistic: str, window: int, seconds: float) -> float | None:
    """The rate of one window that gives the bank this mean time between false alarms; None where no rate of the knob does."""
    def off(log_rate: float) -> float:
        return float(np.log(seconds_between(Rule(statistic, window, float(np.exp(log_rate)))) / seconds))
    low, high = np.log(RATES)
    return None if off(low) * off(high) > 0 else float(np.exp(brentq(off, low, high)))


def duration(seconds: float) -> Text:
    """A time in the unit in which it is easily read."""
    if seconds < 90:
        return text("{time:.3g} s", time=seconds)
    if seconds < 5400:
        return text("{time:.3g} min", time=seconds / 60)
    return text("{time:.3g} h", time=seconds / 3600)
