"""Choose numbers for logarithmic axes, on the page and in exports."""

from __future__ import annotations

import math

from ...text import superscript


def decades(low: float, high: float, most: int = 6) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Powers of ten within [low, high], about `most` of them at most, and their names: 0.1, 1, 10, 10³.

    A range that holds fewer than three of them, which would hardly be a scale, is marked at 1, 2 and 5 as well.
    """
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    if last - first < 2:
        finer = [m * 10.0 ** k for k in range(first - 1, last + 1) for m in (1, 2, 5)]
        kept = tuple(v for v in finer if low * (1 - 1e-9) <= v <= high * (1 + 1e-9))
        return kept, tuple(named(v) for v in kept)
    step = max(1, math.ceil((last - first + 1) / most))
    powers = range(last - (last - first) // step * step, last + 1, step)
    return tuple(10.0 ** k for k in powers), tuple(named(10.0 ** k) for k in powers)


def named(value: float) -> str:
    """0.02, 5, 100, 10³, 2·10⁻⁴."""
    power = math.floor(math.log10(value) + 1e-9)
    if -2 <= power <= 2:
        return f"{value:.6g}"
    times = round(value / 10.0 ** power)
    return ("" if times == 1 else f"{times}·") + "10" + superscript(power)
