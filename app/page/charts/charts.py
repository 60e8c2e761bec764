"""Show figures on the page: time and frequency with uPlot, all others as SVG or HTML tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
import viser

from ...colours import COLOURS
from ...course.figures.curves import thin_samples
from ...course.figures.ranges import LOG_AXIS_FLOOR, decades, steady_range
from ...course.figures.records import Curve, Figure, LineFigure, same_axis, same_key
from ...session.commands.commands import Edit, SetKnobs
from ...session.state.view import Picture
from ...text import label_in_language, superscript
from ..viser_private import viser_internals
from ..viser_private.hidden_input import hidden_input
from ..words.prose import with_minus
from .axes import ticks
from .print_sizes import FRAME_PX, Sizes
from .style_sheet import figure_class
from .svg import draw
from .text_layout import text_width

UPLOT_DASHES: Mapping[str, tuple[float, ...] | None] = MappingProxyType({
    "solid": None, "dash": (9, 5), "dot": (2, 4), "pin1": (3, 3), "pin2": (14, 3), "pin3": (10, 3, 2, 3), "pin4": (6, 2, 2, 2, 2, 2)})

LAST_NUMBER_EM = 1.15  # letters right of a chart, for half of the last number below it: 1000


def _series(curve: Curve, language: str, mark: str, bold: float) -> dict[str, Any]:
    series: dict[str, Any] = {"label": curve.entry(language), "stroke": COLOURS[curve.role], "class": mark,
                              "width": curve.width * bold, "points": {"show": False}}
    dash = UPLOT_DASHES[curve.dash]
    if dash is not None:
        series["dash"] = dash
    return series


def data_of(figure: LineFigure, span: tuple[float, float]) -> tuple[np.ndarray, ...]:
    """The arrays of a chart: sorted x, finite y, at most 500 points, within reach of the shown range."""
    rows = thin_samples(np.asarray(figure.x, dtype=float), *(c.drawn for c in figure.curves))
    reach = 3 * (span[1] - span[0])
    if figure.log_y:
        return rows[0], *(np.clip(np.abs(y), max(span[0] / 1e3, LOG_AXIS_FLOOR), span[1] * 1e3) for y in rows[1:])
    return rows[0], *(np.clip(y, span[0] - reach, span[1] + reach) for y in rows[1:])


def is_over_run_time(figure: Figure, horizon: float) -> bool:
    """Whether a chart's time is that of the run, so that the clock's cursor stands where it should."""
    return isinstance(figure, LineFigure) and not figure.log_x and abs(float(figure.x[-1]) - horizon) <= 0.02 * horizon


def round_numbers(low: float, high: float, most: int) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Round numbers within [low, high] and their names, which tell tiny numbers apart as well: 0.02, −3·10⁻⁵."""
    at = ticks(low, high, most)
    size = max((abs(v) for v in at), default=0.0)
    if not size or 1e-2 <= size < 1e5:
        return tuple(at), tuple(f"{v:.6g}".replace("-", "−") for v in at)
    power = math.floor(math.log10(size) + 1e-9)
    tail = "·10" + superscript(power)
    return tuple(at), tuple(f"{v / 10.0 ** power:.4g}{tail}".replace("-", "−") if v else "0" for v in at)


def stale_figures(picture: Picture, before: Picture | None) -> Sequence[Figure]:
    """The figures that a screen which shows the picture `before` must draw anew."""
    if before is not None and picture.lesson.live is not None and picture.lesson is before.lesson:
        known = {id(figure) for figure in before.seen}
        return [figure for figure in picture.seen if id(figure) not in known]
    if before is None or before.outcome is not picture.outcome or before.pinned != picture.pinned or picture.resting > before.resting:
        return picture.seen
    if not only_completes(picture, before):
        return ()
    drawn = {figure.id for figure in before.seen}
    return [figure for figure in picture.seen if figure.id not in drawn]


def only_completes(picture: Picture, before: Picture | None) -> bool:
    """Whether a picture only adds what the one before it, under a moving knob, has left for later."""
    return before is not None and before.outcome is picture.outcome and before.whole < picture.whole


def what_is_shared(figure: Figure, under: Figure | None) -> str:
    """The end of a class by which the page leaves out what the figure under this one says too."""
    return ("-stacked" if same_axis(figure, under) else "") + ("-keyless" if same_key(figure, under) else "")


class Chart:
    """One figure's widget with its caption. Data are replaced; the chart is rebuilt only when its axes must change.

    What the figure `under` it says as well, its axis, its key and its caption, is written there alone; in large print, where one
    figure fills the column, each says all of it. `mates` is how many figures its tab has.
    """

    def __init__(self, gui: viser.GuiApi, figure: Figure, language: str, sizes: Sizes, horizon: float, under: Figure | None,
                 mates: int = 3, post: Callable[[Edit], object] | None = None) -> None:
        self._language, self._figure = language, figure
        self._alone = sizes.state.lecture
        self._shared = what_is_shared(figure, self._under(under))
        self._cursor = is_over_run_time(figure, horizon)
        self._bold = 1.5 if sizes.state.lecture else 1.0
        self._letter, self._mates, self._room = sizes.chart_letter, mates, sizes.upright(mates)
        self._aspect = self._wide(sizes)
        self._high, self._large = sizes.drawing(mates), sizes.large_words
        self._range: tuple[float, float] | None = None
        self._in_sight, self._hand = False, ""
        self._plot: viser.GuiUplotHandle | None = None
        self._html: viser.GuiHtmlHandle | None = None
        if isinstance(figure, LineFigure):
            self._range = steady_range(figure, None, True)
            self._plot = gui.add_uplot(data_of(figure, self._range), self._all_series(figure), **self._frame(figure))
        else:
            if figure.has_presses and post is not None:
                self._hand = viser_internals.node_id(hidden_input(gui, lambda part: post(SetKnobs(dict(self._figure.pressed(part))))))
            self._html = gui.add_html(self._drawing(figure))
        self._caption = gui.add_html(self._words(figure, under))

    def _wide(self, sizes: Sizes) -> float:
        return (sizes.right - FRAME_PX) / sizes.chart(self._mates)

    def set_visible(self, visible: bool) -> None:
        """Show or hide the figure with its caption; a chart that comes into sight has the range of what it shows now."""
        if visible and not self._in_sight and isinstance(self._figure, LineFigure):
            self._take_range(self._figure, steady_range(self._figure, None, True))
        self._in_sight = visible
        for handle in (self._plot, self._html, self._caption):
            if handle is not None and handle.visible != visible:
                handle.visible = visible

    def take_room(self, sizes: Sizes) -> None:
        """The column has another width: a chart keeps its height, a drawing is drawn for it."""
        self._aspect = self._wide(sizes)
        if self._plot is not None:
            self._plot.aspect = self._aspect
        shape = self._high, self._large
        self._high, self._large = sizes.drawing(self._mates), sizes.large_words
        if self._html is not None and shape != (self._high, self._large):
            self._html.content = self._drawing(self._figure)

    def draw_as_high_as(self, high: float) -> None:
        """Draw a plane or a map in another height."""
        if self._html is not None and high != self._high:
            self._high = high
            self._html.content = self._drawing(self._figure)

    def _drawing(self, figure: Figure) -> str:
        return draw(figure, self._language, self._large, self._high, self._hand)

    def _under(self, under: Figure | None) -> Figure | None:
        return None if self._alone else under

    def _words(self, figure: Figure, under: Figure | None) -> str:
        other = self._under(under)
        said = "" if other is not None and other.caption == figure.caption else with_minus(figure.caption(self._language))
        return f'<p class="ol-caption" data-figure="{figure.id}">{said}</p>'

    def _all_series(self, figure: LineFigure) -> tuple[Any, ...]:
        mark = "ol-time" if self._cursor else "ol-still"
        x: dict[str, Any] = {"label": figure.x_label[0], "class": "ol-x"}
        told, end = [c.key for c in figure.curves], f"{self._shared}{figure_class(figure.id)}"
        return (x, *(_series(c, self._language, "ol-x" if told[k] in told[:k] else f"{mark}-{c.dash}{end}", self._bold)
                     for k, c in enumerate(figure.curves)))

    def _worded(self, figure: LineFigure) -> tuple[str, str]:
        """The title, and the name of the vertical axis, which stands in the title where it would not fit beside its axis."""
        title, name = figure.title(self._language), label_in_language(figure.y_label, self._language)
        return (title, name) if text_width(name, self._letter) <= self._room else (f"{title} · {name}", " ")

    def _frame(self, figure: LineFigure) -> dict[str, Any]:
        assert self._range is not None
        ends = float(figure.x[0]), float(figure.x[-1])
        y: dict[str, Any] = {"range": self._range, "auto": False}
        if figure.log_y:
            y["distr"] = 3
        xs: dict[str, Any] = {"time": False, "range": ends}
        if figure.log_x:
            xs["distr"] = 3
        size, (title, name) = self._letter, self._worded(figure)
        font = f"{size}px sans-serif"
        look = {"font": font, "labelFont": font, "stroke": COLOURS["chart-ink"], "grid": {"stroke": COLOURS["chart-grid"], "width": 1},
                "ticks": {"stroke": COLOURS["chart-frame"], "width": 1}}
        vertical: dict[str, Any] = {**look, "label": name, "labelSize": size + 6, "size": 4 * size + 8}
        if figure.log_y:
            vertical["splits"], vertical["values"] = decades(*self._range)
        else:
            vertical["splits"], vertical["values"] = round_numbers(*self._range, 5)
        horizontal: dict[str, Any] = {**look, "label": figure.x_label, "labelSize": size + 6,
                                      "size": size + 16}
        horizontal["splits"], horizontal["values"] = decades(*ends) if figure.log_x else round_numbers(*ends, 6)
        return {
            "title": title, "scales": {"x": xs, "y": y}, "aspect": self._aspect,
            "axes": (horizontal, vertical),
            "legend": {"show": True, "live": False}, "cursor": {"drag": {"x": False, "y": False}},
            "padding": (10, max(14, round(LAST_NUMBER_EM * size)), 0, 0),
        }

    def show_curves(self, figure: Figure, resting: bool, horizon: float, under: Figure | None) -> None:
        """Draw present data over time or frequency; `show_words` draws the rest."""
        before, self._figure = self._figure, figure
        if isinstance(figure, LineFigure):
            shared, self._shared = self._shared, what_is_shared(figure, self._under(under))
            self._show_plot(figure, before, resting, is_over_run_time(figure, horizon), shared != self._shared)

    def show_words(self, figure: Figure, under: Figure | None) -> None:
        """Write the caption, and draw what is not over time or frequency."""
        if self._html is not None:
            content = self._drawing(figure)
            if content != self._html.content:
                self._html.content = content
        words = self._words(figure, under)
        if words != self._caption.content:
            self._caption.content = words

    def _show_plot(self, figure: LineFigure, before: Figure, resting: bool, cursor: bool, anew: bool) -> None:
        assert self._plot is not None and isinstance(before, LineFigure)
        wanted = steady_range(figure, self._range, resting)
        turned, self._cursor = cursor != self._cursor, cursor
        if turned or anew or len(figure.curves) != len(before.curves) or any(
                (a.key, a.role) != (b.key, b.role) for a, b in zip(figure.curves, before.curves, strict=True)):
            self._plot.series = self._all_series(figure)
        if self._worded(figure)[0] != self._worded(before)[0]:
            self._plot.title = self._worded(figure)[0]
        if (wanted != self._range or figure.log_y != before.log_y or float(figure.x[-1]) != float(before.x[-1])
                or figure.y_label != before.y_label):
            self._take_range(figure, wanted, True)
        else:
            self._plot.data = data_of(figure, wanted)

    def _take_range(self, figure: LineFigure, wanted: tuple[float, float], anew: bool = False) -> None:
        """Draw the curves over another range, unless it is the same and nothing else is to be drawn `anew`."""
        if self._plot is None or (wanted == self._range and not anew):
            return
        self._range = wanted
        frame = self._frame(figure)
        self._plot.scales, self._plot.axes = frame["scales"], frame["axes"]
        self._plot.data = data_of(figure, wanted)
