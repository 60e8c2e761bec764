"""Choose round numbers for axes."""

from __future__ import annotations

import math


def ticks(low: float, high: float, count: int = 6) -> list[float]:
    """Round numbers within [low, high], about `count` of them."""
    raw = (high - low) / count
    if not raw > 0 or not math.isfinite(raw):
        return [low]
    decade = 10.0 ** math.floor(math.log10(raw))
    step = next(s * decade for s in (1, 2, 5, 10) if s * decade >= raw * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [round(i * step, 12 - math.floor(math.log10(raw))) + 0.0 for i in range(first, last + 1)]
