"""Compute a cumulative sum (CUSUM) test: sums, threshold for equal false alarms, crossing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import chdtr, chdtri

from .diagnosis import Rule
from .observer_bank import guard
from .run_length import member_run
from .runs import Record

CELLS = 160  # of the Markov chain
LOG_ARL_TOLERANCE = 1e-9  # of the log of the mean run length, when the threshold is found
MAX_ITERATIONS = 60


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
