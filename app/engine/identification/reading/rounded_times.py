"""Find the regular step behind times that were written with too few decimals."""

from __future__ import annotations

import numpy as np

from ...systems.errors import Phrase, phrase
from ..records import REGULAR

__all__ = ["unrounded"]

DECIMALS = 6  # of the finest times that are looked at
COARSEST = 0.5  # of a step: what the last decimal may be worth, so that a missing row never looks like rounding
SLACK = 1e-6


def unrounded(t: np.ndarray) -> tuple[np.ndarray, tuple[Phrase, ...]]:
    """Times at a regular step, with a note, where those given in s differ from them by the rounding of their last decimal alone."""
    count = len(t) - 1
    step = float(t[-1] - t[0]) / count if count > 1 else 0.0
    if not step > 0 or np.abs(np.diff(t) - step).max() <= REGULAR * step:
        return t, ()
    last = next((10.0**-k for k in range(DECIMALS + 1) if np.abs(np.round(t * 10**k) - t * 10**k).max() <= 1e-4), 0.0)
    if not 0 < last <= COARSEST * step:
        return t, ()
    rows = np.arange(count + 1)
    rate = round(1 / step)
    for regular in ((1 / rate, step) if rate else (step,)):
        if np.ptp(t - regular * rows) <= last * (1 + SLACK):
            return t[0] + regular * rows, (phrase(
                "The times are rounded to {last:g} s; the rows were read at a regular step of {step:.4g} s.", last=last, step=regular),)
    return t, ()
