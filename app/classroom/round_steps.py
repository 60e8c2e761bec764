"""Round a step up to 1, 2 or 5 times a power of ten."""

from __future__ import annotations

import math


def round_step(least: float) -> float:
    """The next of 1, 2, 5 times a power of ten."""
    decade = 10.0 ** math.floor(math.log10(least))
    return next(times * decade for times in (1, 2, 5, 10) if times * decade >= least * (1 - 1e-9))
