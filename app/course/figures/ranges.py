"""Choose the range that an axis shows, keep it while a knob moves, and number a logarithmic one."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...text import superscript
from .curves import finite
from .records import LineFigure

LOG_AXIS_FLOOR = 1e-12  # the lowest value that a logarithmic axis shows

NICE_STEPS, FINE_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0), (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)


def round_up_nicely(value: float, steps: Sequence[float] = NICE_STEPS) -> float:
    """The least of 1, 2, 2.5, 5 × 10^k, or of other `steps` of a decade, that is not below `value`."""
    if not value > 0 or not math.isfinite(value):
        return 1.0
    decade = 10.0 ** math.floor(math.log10(value))
    for step in steps:
        if value <= step * decade * (1 + 1e-9):
            return step * decade
    return 10.0 * decade


def axis_range(figure: LineFigure) -> tuple[float, float]:
    """A calm y range for all curves of a figure: round numbers, zero inside, decades when logarithmic."""
    data = [finite(curve.y) for curve in figure.curves if len(curve.y)]
    if figure.log_y:
        top = max((float(np.max(np.abs(y))) for y in data), default=1.0)
        bottom = min((float(np.min(np.abs(y[np.abs(y) > LOG_AXIS_FLOOR]), initial=top)) for y in data), default=top)
        if figure.window is not None:
            top, bottom = max(top, figure.window[1]), min(bottom, figure.window[0])
        top = max(top, 10 * LOG_AXIS_FLOOR)
        high = 10.0 ** math.ceil(math.log10(top) - 1e-9)
        deepest = high * 1e-9 if figure.window is None else min(high * 1e-9, figure.window[0])
        low = 10.0 ** math.floor(math.log10(max(bottom, deepest, LOG_AXIS_FLOOR)) + 1e-9)
        return min(low, high / 10), high
    low = min((float(np.min(y)) for y in data), default=-1.0)
    high = max((float(np.max(y)) for y in data), default=1.0)
    if figure.most is not None:
        low, high = max(low, figure.most[0]), min(high, figure.most[1])
    if figure.window is not None:
        low, high = min(low, figure.window[0]), max(high, figure.window[1])
    low, high = (-round_up_nicely(-low * 1.02, FINE_STEPS) if low < 0 else 0.0,
                 round_up_nicely(high * 1.02, FINE_STEPS) if high > 0 else 0.0 if low < 0 else 1.0)
    return (low, high) if low < high else (0.0, 1.0)  # numbers that are zero to a chart


def legal_range(low: float, high: float, log: bool) -> bool:
    """Whether an axis can have that range."""
    return math.isfinite(low) and math.isfinite(high) and low < high and (low > 0 or not log)


def steady_range(figure: LineFigure, last: tuple[float, float] | None, resting: bool) -> tuple[float, float]:
    """The y range to show now: it stays put while a knob moves and follows, if it must, when the knob rests.

    A range that is kept is one that the figure can have now: finite, rising, and positive on a logarithmic axis.
    """
    log = figure.log_y
    kept = last if last is not None and legal_range(*last, log) else None
    if kept is not None and not resting:
        return kept
    wanted = axis_range(figure)
    if kept is None:
        return wanted
    last = kept
    if log:
        inside = last[0] <= wanted[0] * 1.01 and wanted[1] <= last[1] * 1.01
        loose = math.log10(last[1] / last[0]) > 2.5 * math.log10(wanted[1] / wanted[0])
    else:
        inside = last[0] <= wanted[0] and wanted[1] <= last[1]
        loose = last[1] - last[0] > 4.1 * (wanted[1] - wanted[0])
    return last if inside and not loose else wanted


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
