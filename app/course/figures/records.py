"""Define figure records, drawn by uPlot or SVG on the page and by matplotlib in exports.

A record holds arrays and words, never a widget, and says itself what a table, a screen reader or a file needs. Roles name meanings;
`colours.py` gives each its colour everywhere. A new kind stands in `Figure`, and is drawn in: `svg.py`, `export/figures/figure.py`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np

from ...text import NO_WORDS, Text, label_in_language, text
from .curves import Curve as Curve
from .curves import Dash as Dash
from .curves import Point as Point
from .curves import finite as finite
from .diagram import DiagramFigure as DiagramFigure
from .figure_record import Entry, FigureRecord, Part, PinnedFigure, Sheet, WordTable, distinct, numbered
from .gauges import GaugeFigure as GaugeFigure
from .matrix_figure import MATRICES as MATRICES
from .matrix_figure import MatrixFigure as MatrixFigure

# the tabs that figures stand in unless a lesson says otherwise
TIME, SPECTRUM, PLANE = text("Time"), text("Spectrum"), text("Plane")
MAP, NUMBERS = text("Map"), text("Numbers")
UNIT = re.compile(r"\[[^\[\]]+\]\s*$")  # at the end of an axis or a name


@dataclass(frozen=True, eq=False)
class LineFigure(FigureRecord):
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
    most: tuple[float, float] | None = None  # the largest range that it shows; curves may leave it

    @property
    def x_label(self) -> str:
        """What the curves run over."""
        return "f [Hz]" if self.log_x else "t [s]"

    @property
    def kind(self) -> str:
        return "frequency" if self.log_x else "time"

    def axes(self, language: str = "en") -> tuple[str, str]:
        return self.x_label, label_in_language(self.y_label, language)

    def table(self, language: str = "en") -> Sheet:
        """A column a curve, with the unit of its axis where its name has none."""
        unit = UNIT.search(self.axes(language)[1])
        names = [name if unit is None or UNIT.search(name) else f"{name} {unit[0]}".strip() for name in
                 (curve.called(language) for curve in self.curves)]
        columns = [np.asarray(self.x, dtype=float), *(np.asarray(curve.y, dtype=float) for curve in self.curves)]
        return [self.x_label, *distinct(names)], [tuple(map(float, row)) for row in zip(*columns, strict=True)]

    def entries(self) -> Iterator[Entry]:
        for name, curve in zip(distinct([curve.called("en") for curve in self.curves]), self.curves, strict=True):
            yield from ((name, float(x), float(y), "") for x, y in zip(self.x, curve.y, strict=True))

    def parts(self) -> Iterator[Part]:
        yield from (("x", self.x_label), ("y", self.y_label), *numbered("curve", (curve.name for curve in self.curves)))

    def with_pins(self, pinned: Sequence[PinnedFigure]) -> Self:
        """The other's curves over its own x, where they have its axes and are not drawn anyway; nothing where they do not reach."""
        axes, x, thin = (self.log_x, self.log_y, self.y_label), np.asarray(self.x, dtype=float), []
        for place, pin, other in pinned:
            if not isinstance(other, LineFigure) or axes != (other.log_x, other.log_y, other.y_label):
                continue
            at = np.asarray(other.x, dtype=float)
            for curve in other.curves:
                y = finite(curve.y)
                if len(at) < 2 or len(y) != len(at):
                    continue
                if len(x) != len(at) or not np.array_equal(x, at):
                    y = np.interp(x, at, y, left=np.nan, right=np.nan)
                thin.append(curve.of_pin(place, pin, y, None))
        return replace(self, curves=(*self.curves, *(curve for curve in thin if not curve.lies_on(self.curves))))


def over_frequency(id: str, title: Text, f: np.ndarray, curves: tuple[Curve, ...], y_label: Text | str = "",
                   caption: Text = NO_WORDS, tab: Text = SPECTRUM, window: tuple[float, float] | None = None) -> LineFigure:
    """Curves over frequency in hertz, both axes logarithmic."""
    return LineFigure(id, title, f, curves, y_label, True, True, caption, tab, window)


@dataclass(frozen=True, eq=False)
class PlaneFigure(FigureRecord):
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
    names: tuple[tuple[float, Text], ...] = ()  # what stands below places of the x axis instead of its numbers

    @property
    def kind(self) -> str:
        return "plane"

    def axes(self, language: str = "en") -> tuple[str, str]:
        """What stands at the axes; an exponent is a logarithm."""
        x, y = (label_in_language(label, language) for label in (self.x_label, self.y_label))
        return f"log₁₀ {x or 'x'}" if "x" in self.powers else x, f"log₁₀ {y or 'y'}" if "y" in self.powers else y

    def table(self, language: str = "en") -> Sheet:
        """A row a point, curve by curve and then the marks."""
        x, y = self.axes(language)
        names = distinct([curve.called(language) for curve in self.curves])
        rows = [(name, float(x), float(y)) for name, curve in zip(names, self.curves, strict=True)
                for x, y in zip(curve.xs, curve.y, strict=True)]
        return ["series", x or "x", y or "y"], [*rows, *((point.called(language), float(point.x), float(point.y)) for point in self.points)]

    def entries(self) -> Iterator[Entry]:
        yield from ((str(name), float(x), float(y), "") for name, x, y in self.table()[1])

    def parts(self) -> Iterator[Part]:
        yield from (("x", self.x_label), ("y", self.y_label), *numbered("curve", (curve.name for curve in self.curves)),
                    *numbered("point", (point.name for point in self.points)), *numbered("place", (name for _, name in self.names)))

    def with_pins(self, pinned: Sequence[PinnedFigure]) -> Self:
        curves, points, there = list(self.curves), list(self.points), {point.key for point in self.points}
        for place, pin, other in pinned:
            if isinstance(other, PlaneFigure):
                curves += [curve.of_pin(place, pin, curve.y, curve.x) for curve in other.curves if not curve.lies_on(self.curves)]
                points += [replace(point, mark="hollow", name=NO_WORDS) for point in other.points
                           if point.mark in ("cross", "dot") and point.key not in there]
        return replace(self, curves=tuple(curves), points=tuple(points))


@dataclass(frozen=True, eq=False)
class MapFigure(FigureRecord):
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

    @property
    def kind(self) -> str:
        return "map"

    def axes(self, language: str = "en") -> tuple[str, str]:
        return label_in_language(self.x_label, language), label_in_language(self.y_label, language)

    def table(self, language: str = "en") -> Sheet:
        """A row a cell."""
        x, y = self.axes(language)
        return [x or "x", y or "y", "category"], [(x, y, name) for name, x, y, _ in self._cells(language)]

    def entries(self) -> Iterator[Entry]:
        return self._cells("en")

    def _cells(self, language: str) -> Iterator[Entry]:
        names = [name(language) for name, _ in self.categories]
        for (i, j), k in np.ndenumerate(np.asarray(self.values)):
            yield names[int(k)] if k >= 0 else "", float(self.x[j]), float(self.y[i]), float(k)

    def parts(self) -> Iterator[Part]:
        yield from (("x", self.x_label), ("y", self.y_label), *numbered("category", (name for name, _ in self.categories)))


@dataclass(frozen=True, eq=False)
class TableFigure(WordTable):
    """A table: what is asked beside what is reached, numbers beside names."""

    id: str
    title: Text
    columns: tuple[Text, ...]
    rows: tuple[tuple[Text | str, ...], ...]
    caption: Text = NO_WORDS
    tab: Text = NUMBERS

    @property
    def kind(self) -> str:
        return "table"

    def cells(self) -> tuple[tuple[Text, ...], tuple[tuple[Text | str, ...], ...]]:
        return self.columns, self.rows


Figure = LineFigure | PlaneFigure | MatrixFigure | MapFigure | TableFigure | DiagramFigure | GaugeFigure


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
