"""Compute how long windows and cumulative sums (CUSUM) run on average before a false alarm."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from numpy.polynomial.polynomial import polyval
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from scipy.special import chdtr, chdtri

from observer_lab.text import Text, text

from .diagnosis import ENERGY, MEAN, Rule
from .observer_bank import DT, guard
from .run_length_table import BANK_ENERGY, BANK_MEAN, MEMBER_ENERGY, MEMBER_MEAN, WINDOWS
from .runs import Record

MEMBER = MappingProxyType({ENERGY: MEMBER_ENERGY, MEAN: MEMBER_MEAN})
BANK = MappingProxyType({ENERGY: BANK_ENERGY, MEAN: BANK_MEAN})
RATES = (1e-6, 0.1)
CELLS = 160  # of the Markov chain
LOG_ARL_TOLERANCE = 1e-9  # of the log of the mean run length, when the threshold is found
MAX_ITERATIONS = 60


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


@dataclass(frozen=True, eq=False)
class Cusum:
    """values (SAMPLE_COUNT, 7): the sum over its threshold; slack κ; threshold h; mean: samples between two false alarms of one member."""

    values: np.ndarray
    slack: float
    threshold: float
    mean: float


def cusum(test: Rule, record: Record) -> Cusum:
    """g_k = max(0, g_{k−1} + q_k − d − κ) of each member, q_k = ‖r_k‖² its whitened innovation's square, χ² with d degrees of freedom.

    κ is half of what the least fault that the window sees with DETECTION_POWER adds to a sample; h gives the mean time between
    false alarms of the window that is tested at every sample. Source: Page, Continuous inspection schemes (1954).
    """
    d, mean = guard().bank.dof, member_run(test)
    slack = min(test.needed / (2 * test.window), (float(chdtri(d, 1 / mean)) - d) / 2)  # never so much that one sample must do it all
    h = threshold(d, slack, mean)
    total = np.cumsum(np.sum(np.asarray(record.residuals) ** 2, axis=2) - d - slack, axis=0)
    return Cusum((total - np.minimum(np.minimum.accumulate(total, axis=0), 0.0)) / h, slack, h, mean)


@lru_cache(maxsize=256)
def threshold(dof: int, slack: float, mean: float) -> float:
    """The h at which the mean run without a fault is `mean` samples: log of it against h is nearly a line, so by secants."""
    low, high, wanted = 0.0, 10.0, np.log(mean)
    f_low, f_high = np.log(run_length(dof, slack, 1e-9)) - wanted, np.log(run_length(dof, slack, high)) - wanted
    for _ in range(MAX_ITERATIONS):
        h = max(high - f_high * (high - low) / (f_high - f_low), 1e-9)
        low, f_low, high, f_high = high, f_high, h, np.log(run_length(dof, slack, h)) - wanted
        if abs(f_high) < LOG_ARL_TOLERANCE or f_high == f_low:
            break
    return float(high)


def run_length(dof: int, slack: float, h: float) -> float:
    """Mean number of samples until g, from zero, passes h, with nothing but χ² noise: a Markov chain over cells of [0, h].

    State 0 is g = 0, the others the middles of the cells. Source: Brook and Evans (1972).
    """
    width = h / CELLS
    edges = (np.arange(-CELLS, CELLS + 1)) * width
    middles = (np.arange(CELLS) + 0.5) * width
    starts = np.append(0.0, middles)
    rise = chdtr(dof, np.maximum(np.append(edges, edges[-1] + width) + dof + slack - width / 2, 0.0))  # by cells, for the middles
    step = np.arange(CELLS)
    Q = np.zeros((CELLS + 1, CELLS + 1))
    Q[1:, 1:] = np.diff(rise)[CELLS + step[None, :] - step[:, None]]
    Q[0, 1:] = np.diff(chdtr(dof, np.maximum(np.arange(CELLS + 1) * width + dof + slack, 0.0)))
    Q[:, 0] = chdtr(dof, np.maximum(dof + slack - starts, 0.0))
    return float(np.linalg.solve(np.eye(CELLS + 1) - Q, np.ones(CELLS + 1))[0])
