"""Define figure records, drawn by uPlot or SVG on the page and by matplotlib in exports.

A record holds arrays and words, never a widget. Roles name meanings; `colours.py` gives each its colour everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, assert_never

import numpy as np

from ...text import NO_WORDS, Text, label_in_language, text

Dash = Literal["solid", "dash", "dot", "pin1", "pin2", "pin3", "pin4"]
# the tabs that figures stand in unless a lesson says otherwise
TIME, SPECTRUM, PLANE = text("Time"), text("Spectrum"), text("Plane")
MATRICES, MAP, NUMBERS = text("Matrices"), text("Map"), text("Numbers")
LOG_AXIS_FLOOR = 1e-12  # the lowest value that a logarithmic axis shows


@dataclass(frozen=True, eq=False)
class Curve:
    """One line: y over the figure's common x (or over its own `x` in a plane).

    One with a `pin` belongs to the pinned design of that name; it alone may hold NaN, where its run does not reach.
    """

    name: Text
    y: np.ndarray
    role: str = "plant"
    dash: Dash = "solid"
    width: float = 2.0
    x: np.ndarray | None = None
    pin: Text = NO_WORDS

    def called(self, language: str) -> str:
        """Its name, with that of its pin: "true · A"."""
        return " · ".join(each for each in (self.name(language), self.pin(language)) if each)

    @property
    def key(self) -> tuple[Text, str, str]:
        """What tells it apart in a key: a pin has one entry there, whatever its curves are."""
        return (self.pin, "", self.dash) if self.pin.id else (self.name, self.role, self.dash)

    def entry(self, language: str) -> str:
        """Its name in a key."""
        return (self.pin if self.pin.id else self.name)(language)

    @property
    def drawn(self) -> np.ndarray:
        """Its values fit to draw."""
        return np.asarray(self.y, dtype=float) if self.pin.id else finite(self.y)


@dataclass(frozen=True, eq=False)
class LineFigure:
    """Curves over time in seconds or, where `log_x`, over frequency in hertz; `log_y` draws their magnitudes in decades."""

    id: str
    title: Text
    x: np.ndarray
    curves: tuple[Curve, ...]
    y_label: Text | str = ""
    log_x: bool = False
    log_y: bool = False
    caption: Text = NO_WORDS
    tab: Text = TIME
    window: tuple[float, float] | None = None  # the least range that the y axis shows

    @property
    def x_label(self) -> str:
        """What the curves run over."""
        return "f [Hz]" if self.log_x else "t [s]"


def over_frequency(id: str, title: Text, f: np.ndarray, curves: tuple[Curve, ...], y_label: Text | str = "",
                   caption: Text = NO_WORDS, tab: Text = SPECTRUM, window: tuple[float, float] | None = None) -> LineFigure:
    """Curves over frequency in hertz, both axes logarithmic."""
    return LineFigure(id, title, f, curves, y_label, True, True, caption, tab, window)


@dataclass(frozen=True, eq=False)
class Point:
    """A mark in a plane: a cross (pole), a circle (zero, start), a bolt (a mode that cannot move), hollow (of a pin)."""

    x: float
    y: float
    role: str = "plant"
    mark: Literal["cross", "circle", "bolt", "dot", "hollow"] = "cross"
    name: Text = NO_WORDS


@dataclass(frozen=True, eq=False)
class PlaneFigure:
    """Curves and points in a plane: pole maps, phase portraits, ellipses."""

    id: str
    title: Text
    curves: tuple[Curve, ...] = ()
    points: tuple[Point, ...] = ()
    x_label: Text | str = ""
    y_label: Text | str = ""
    x_range: tuple[float, float] = (-1.0, 1.0)
    y_range: tuple[float, float] = (-1.0, 1.0)
    equal: bool = False
    unstable: bool = False  # shade Re s > 0
    caption: Text = NO_WORDS
    tab: Text = PLANE
    powers: Literal["", "x", "y", "xy"] = ""  # the axes over which exponents of ten run, and which are numbered 10⁻³, 1, 10³


@dataclass(frozen=True, eq=False)
class MatrixFigure:
    """A heat map of the magnitudes of a matrix, with lines between its blocks."""

    id: str
    title: Text
    matrix: np.ndarray
    rows: tuple[Text | str, ...] = ()
    columns: tuple[Text | str, ...] = ()
    blocks: tuple[int, ...] = ()  # a line is drawn before each of these rows and columns
    caption: Text = NO_WORDS
    tab: Text = MATRICES


@dataclass(frozen=True, eq=False)
class MapFigure:
    """A map over a grid: `values` (n_y, n_x) of numbers of categories with name and role, −1 where none is computed yet."""

    id: str
    title: Text
    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    categories: tuple[tuple[Text, str], ...]
    x_label: Text | str = ""
    y_label: Text | str = ""
    marked: tuple[float, float] | None = None
    caption: Text = NO_WORDS
    tab: Text = MAP


@dataclass(frozen=True, eq=False)
class TableFigure:
    """A table: what is asked beside what is reached, numbers beside names."""

    id: str
    title: Text
    columns: tuple[Text, ...]
    rows: tuple[tuple[Text | str, ...], ...]
    caption: Text = NO_WORDS
    tab: Text = NUMBERS


Figure = LineFigure | PlaneFigure | MatrixFigure | MapFigure | TableFigure


def finite(values: np.ndarray, bound: float = 1e12) -> np.ndarray:
    """Values fit to draw: NaN becomes 0, and what exceeds ±bound is clipped."""
    return np.clip(np.nan_to_num(np.asarray(values, dtype=float), nan=0.0, posinf=bound, neginf=-bound), -bound, bound)


def round_up_nicely(value: float) -> float:
    """The least of 1, 2, 2.5, 5 × 10^k that is not below `value`."""
    if not value > 0 or not math.isfinite(value):
        return 1.0
    decade = 10.0 ** math.floor(math.log10(value))
    for step in (1.0, 2.0, 2.5, 5.0, 10.0):
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
    if figure.window is not None:
        low, high = min(low, figure.window[0]), max(high, figure.window[1])
    low, high = (-round_up_nicely(-low * 1.02) if low < 0 else 0.0), (round_up_nicely(high * 1.02) if high > 0 else 0.0 if low < 0 else 1.0)
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


def columns(figure: Figure) -> tuple[list[str], np.ndarray]:
    """The data of a figure as named columns, for a CSV file and for tests."""
    match figure:
        case LineFigure():
            return [figure.x_label, *(c.name("en") for c in figure.curves)], np.column_stack([figure.x, *(c.y for c in figure.curves)])
        case PlaneFigure():
            rows = [(p.x, p.y) for p in figure.points] + [at for c in figure.curves for at in zip(_xs(c), c.y, strict=True)]
            return [*axes_of(figure)], np.array(rows, dtype=float).reshape(-1, 2)
        case MatrixFigure():
            named = figure.columns or map(str, range(figure.matrix.shape[1]))
            return [label_in_language(name, "en") for name in named], np.asarray(figure.matrix, dtype=float)
        case MapFigure():
            x, y = np.meshgrid(figure.x, figure.y)
            return [*axes_of(figure), "category"], np.column_stack([x.ravel(), y.ravel(), figure.values.ravel()])
        case TableFigure():
            return [c("en") for c in figure.columns], np.empty((0, len(figure.columns)))
        case _:
            assert_never(figure)


def axes_of(figure: PlaneFigure | MapFigure, language: str = "en") -> tuple[str, str]:
    """What the numbers of a figure are, as a table says it: an exponent is a logarithm."""
    def axis(label: Text | str, name: str) -> str:
        return "log₁₀ " * (name in getattr(figure, "powers", "")) + (label_in_language(label, language) or name)
    return axis(figure.x_label, "x"), axis(figure.y_label, "y")


def _xs(curve: Curve) -> np.ndarray:
    return np.arange(len(curve.y), dtype=float) if curve.x is None else curve.x


def thin_samples(t: np.ndarray, *series: np.ndarray, points: int = 500) -> tuple[np.ndarray, ...]:
    """Every k-th sample, the last one kept, so that a curve has at most `points` + 1 points on the screen."""
    step = max(1, math.ceil(len(t) / points))
    index = np.unique(np.append(np.arange(0, len(t), step), len(t) - 1))
    return (t[index], *(s[index] for s in series))


def tab_names(figures: Sequence[Figure]) -> list[Text]:
    """The tabs in the order in which figures first name them."""
    return list(dict.fromkeys(figure.tab for figure in figures))


def figure_below(figures: Sequence[Figure], figure: Figure) -> Figure | None:
    """The figure that stands under another one in its tab."""
    own = [each for each in figures if each.tab == figure.tab]
    after = [index for index, each in enumerate(own) if each.id == figure.id]
    return own[after[0] + 1] if after and after[0] + 1 < len(own) else None


def same_axis(figure: Figure, under: Figure | None) -> bool:
    """Whether the axis of the figure under this one is its own too, and so need not be written twice."""
    return (isinstance(figure, LineFigure) and isinstance(under, LineFigure) and figure.log_x == under.log_x
            and float(figure.x[0]) == float(under.x[0]) and float(figure.x[-1]) == float(under.x[-1]))


def same_key(figure: Figure, under: Figure | None) -> bool:
    """Whether the key of the figure under this one explains its curves too."""
    return isinstance(figure, LineFigure) and isinstance(under, LineFigure) and (
        {c.key for c in figure.curves} <= {c.key for c in under.curves})
