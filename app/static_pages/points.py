"""Choose the values of a knob to which a published page snaps."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..course.knobs import Choice, Knob, KnobError, Number, Poles, Switch
from ..course.scenes import Goal
from ..engine import EngineError
from ..engine.systems import move_pole

MOST_PLACES, LEAST_UP = 150, 4  # of all poles of a board together: where more can move the grid is coarser, down to so many heights
SNAP = 1e-3  # of a board's height: a pole that is nearer to the real axis lies on it


@dataclass(frozen=True)
class Points:
    """How many values a slider has, and how many places a pole has along the real and the imaginary axis."""

    slider: int = 7
    across: int = 9
    up: int = 7


def values_of(knob: Knob, now: Any, points: Points, wanted: Iterable[Any] = ()) -> tuple[Any, ...]:
    """The values of a knob that are computed beside the present one; `wanted` are among them. None for a knob that is drawn by hand."""
    found: list[Any] = [*wanted]
    if isinstance(knob, Number):
        found += _numbers(knob, points.slider)
    elif isinstance(knob, Choice):
        found += [name for name, _ in knob.options]
    elif isinstance(knob, Switch):
        found += [False, True]
    elif isinstance(knob, Poles):
        found += _places(knob, now, points)
    checked = dict.fromkeys(_accepted(knob, found))
    checked.pop(now, None)
    return tuple(checked)


def value_for(knob: Knob, goal: Goal) -> Any:
    """A value that a scene asks for, in the middle of its bounds where it has two; None where any grid has one, or none can be named."""
    if goal.value is not None:
        return goal.value
    if not isinstance(knob, Number) or goal.least is None or goal.most is None:
        return None
    middle = math.sqrt(goal.least * goal.most) if knob.scale == "log" else (goal.least + goal.most) / 2
    return _on_scale(knob, middle)


def _numbers(knob: Number, count: int) -> list[float]:
    spread = np.geomspace if knob.scale == "log" else np.linspace
    return [*(_on_scale(knob, value) for value in spread(knob.low, knob.high, count)[1:-1].tolist()), knob.low, knob.high]


def _on_scale(knob: Number, value: float) -> float:
    """The nearest value that a slider shows: one that moves in decades shows three decimals of them."""
    if knob.scale == "log":
        return float(f"{10.0 ** round(math.log10(value), 3):.10g}")
    step = 1.0 if knob.scale == "integer" else knob.step or 10.0 ** math.floor(math.log10((knob.high - knob.low) / 100))
    return float(f"{min(max(knob.low + step * round((value - knob.low) / step), knob.low), knob.high):.10g}")  # 0.35, not 0.35 + 6e-17


def _places(knob: Poles, now: tuple[complex, ...], points: Points) -> list[tuple[complex, ...]]:
    """The present poles with one pair, or one real pole, at each place of a grid over the board, coarser where many can move."""
    out, (across, up) = list[tuple[complex, ...]](), (points.across, points.up)
    while sum(pole.imag >= 0 for pole in now) * across * up > MOST_PLACES and up > LEAST_UP:
        across, up = across - 1, up - 1
    for index, pole in enumerate(now):
        if pole.imag < 0:
            continue
        heights = [0.0] if pole.imag == 0 else np.linspace(0.0, knob.im_high, up).tolist()
        for real in np.linspace(knob.re_low, knob.re_high, across).tolist():
            for height in heights:
                try:
                    out.append(move_pole(now, index, complex(real, height), axis_snap=SNAP * knob.im_high))
                except EngineError:  # poles that cannot stand together
                    continue
    return out


def _accepted(knob: Knob, values: Iterable[Any]) -> Iterable[Any]:
    for value in values:
        try:
            yield knob.check(value)
        except KnobError:
            continue
