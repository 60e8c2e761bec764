"""Draw one figure record on matplotlib axes: curves, planes, maps, gauges, matrices and tables."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from scipy.ndimage import distance_transform_cdt

from ...colours import COLOURS
from ...course.figures.matrix_figure import FULL
from ...course.figures.ranges import LOG_AXIS_FLOOR, axis_range, decades
from ...course.figures.records import Curve, GaugeFigure, LineFigure, MapFigure, MatrixFigure, PlaneFigure, TableFigure, finite
from ...text import format_number, label_in_language, symbol
from .curve_labels import label_curves
from .style import GRID_COLOUR, INK_COLOUR, RULE_COLOUR, SMALL_PT, curve_style, escape_mathtext, text_width_em

__all__ = ["draw_gauges", "draw_lines", "draw_map", "draw_matrix", "draw_plane", "draw_table", "shade"]

MARK_STYLES = MappingProxyType({
    "cross": {"marker": "x", "markersize": 5.0, "markeredgewidth": 1.3},
    "circle": {"marker": "o", "markersize": 5.5, "markerfacecolor": "none", "markeredgewidth": 1.0},
    "ring": {"marker": "o", "markersize": 9.5, "markerfacecolor": "none", "markeredgewidth": 1.0},
    "hollow": {"marker": "D", "markersize": 4.2, "markerfacecolor": "none", "markeredgewidth": 0.8},
    "dot": {"marker": "o", "markersize": 3.6, "markeredgewidth": 0.0},
    "up": {"marker": "^", "markersize": 4.6, "markeredgewidth": 0.0},
    "bolt": {"marker": "h", "markersize": 6.0, "markeredgewidth": 0.0},
})
MAP_STRENGTH = 0.75  # opacity of a map's colours on white paper


def draw_lines(axes: Axes, figure: LineFigure, language: str) -> None:
    """Curves over time or frequency; magnitudes on a logarithmic axis where the record says so."""
    if figure.log_x:
        axes.set_xscale("log")
    axes.set_xlabel(f"${figure.x_label.replace(' ', '$ ')}")
    _span(axes, figure.x[figure.x > 0] if figure.log_x else figure.x)
    _curves(axes, figure, language)


def _span(axes: Axes, x: np.ndarray) -> None:
    if len(x) > 1 and x[-1] > x[0]:
        axes.set_xlim(float(x[0]), float(x[-1]))


def _curves(axes: Axes, figure: LineFigure, language: str) -> None:
    low, high = axis_range(figure)
    if figure.log_y:
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(numticks=6))
        axes.yaxis.set_minor_formatter(NullFormatter())
    else:
        axes.yaxis.set_major_locator(MaxNLocator(5))
        if low < 0 < high:
            axes.axhline(0.0, color=GRID_COLOUR, linewidth=0.6, zorder=0)
    axes.set_ylim(low, high)
    axes.set_ylabel(escape_mathtext(label_in_language(figure.y_label, language)))
    lines = [_plot(axes, curve, figure.x, np.maximum(np.abs(curve.drawn), LOG_AXIS_FLOOR) if figure.log_y else curve.drawn,
                   language, figure.curves[:k]) for k, curve in enumerate(figure.curves)]
    label_curves(axes, lines)


def _plot(axes: Axes, curve: Curve, x: np.ndarray, y: np.ndarray, language: str, before: tuple[Curve, ...]) -> Line2D:
    """Draw a curve; only the first of several curves with one name carries it."""
    name = curve.entry(language)
    told = not name or any(other.key[:2] == curve.key[:2] for other in before)
    line, = axes.plot(x, y, label="_" if told else escape_mathtext(name), **curve_style(curve))
    return line


def draw_plane(axes: Axes, figure: PlaneFigure, language: str) -> None:
    """Curves and marks in a plane; a mark beyond the range stands on its edge, as on the screen."""
    x_range, y_range = _equal(axes, figure) if figure.equal else (figure.x_range, figure.y_range)
    axes.set_xlim(*x_range)
    axes.set_ylim(*y_range)
    axes.set_xlabel(escape_mathtext(label_in_language(figure.x_label, language)))
    axes.set_ylabel(escape_mathtext(label_in_language(figure.y_label, language)))
    for axis, (low, high), name in ((axes.xaxis, x_range, "x"), (axes.yaxis, y_range, "y")):
        if name in figure.powers:
            at, named = decades(10.0**low, 10.0**high)
            axis.set_ticks(np.log10(at), [escape_mathtext(each) for each in named])
    for draw, (low, high) in ((axes.axvline, x_range), (axes.axhline, y_range)):
        if low < 0 < high:
            draw(0.0, color=RULE_COLOUR, linewidth=0.5, zorder=0.5)
    if figure.unstable and x_range[1] > 0:
        axes.axvspan(max(0.0, x_range[0]), x_range[1], color=COLOURS["unstable"], linewidth=0, zorder=0)
    lines = [_plot(axes, c, np.arange(len(c.y), dtype=float) if c.x is None else finite(c.x), c.drawn, language,
                   figure.curves[:k]) for k, c in enumerate(figure.curves)]
    _marks(axes, figure, language, x_range, y_range)
    label_curves(axes, lines)


def _equal(axes: Axes, figure: PlaneFigure) -> tuple[tuple[float, float], tuple[float, float]]:
    """Both ranges widened about their middles so that a unit is as long across as it is upwards."""
    wide, high = float(axes.bbox.width), float(axes.bbox.height)
    (x0, x1), (y0, y1) = figure.x_range, figure.y_range
    unit = max((x1 - x0) / wide, (y1 - y0) / high) / 2
    return (((x0 + x1) / 2 - unit * wide, (x0 + x1) / 2 + unit * wide),
            ((y0 + y1) / 2 - unit * high, (y0 + y1) / 2 + unit * high))


def _marks(axes: Axes, figure: PlaneFigure, language: str, x_range: tuple[float, float],
           y_range: tuple[float, float]) -> None:
    groups = dict.fromkeys((point.role, point.mark) for point in figure.points)
    for role, mark in groups:
        members = [p for p in figure.points if (p.role, p.mark) == (role, mark)]
        at = finite(np.array([(p.x, p.y) for p in members]))
        at = np.clip(at, (x_range[0], y_range[0]), (x_range[1], y_range[1]))
        axes.plot(at[:, 0], at[:, 1], linestyle="none", color=COLOURS["bolt" if mark == "bolt" else role], clip_on=False,
                  zorder=4, label="_", gid=f"{role}-{mark}", **MARK_STYLES[mark])
        for (x, y), point in zip(at, members, strict=True):
            if point.name(language):
                axes.annotate(escape_mathtext(point.name(language)), (x, y), (4, 3), textcoords="offset points", fontsize=SMALL_PT)


def draw_map(axes: Axes, figure: MapFigure, language: str) -> None:
    """Categories over a grid; a cell that holds −1 stays white. Names stand in their regions where these are large."""
    values = np.asarray(figure.values)
    image = np.ones((*values.shape, 3))
    for k, (_, role) in enumerate(figure.categories):
        image[values == k] = 1 - MAP_STRENGTH * (1 - np.array(to_rgb(COLOURS[role])))
    extent = (*_edges(figure.x), *_edges(figure.y))
    axes.imshow(image, origin="lower", extent=extent, interpolation="nearest", aspect="auto", zorder=0)
    axes.set_xlabel(escape_mathtext(label_in_language(figure.x_label, language)))
    axes.set_ylabel(escape_mathtext(label_in_language(figure.y_label, language)))
    if figure.marked is not None:
        axes.plot(*figure.marked, linestyle="none", color=COLOURS["reference"], clip_on=False, zorder=5, label="_",
                  **MARK_STYLES["circle"])
    homeless = [Patch(color=image[values == k][0], label=escape_mathtext(name(language)))
                for k, (name, _) in enumerate(figure.categories)
                if (values == k).any() and not _name_region(axes, figure, values == k, name(language))]
    if homeless:
        axes.legend(handles=homeless, loc="upper right", frameon=True, framealpha=0.9, edgecolor="none", borderpad=0.3)


def _name_region(axes: Axes, figure: MapFigure, region: np.ndarray, name: str) -> bool:
    """Write the name of a region at its innermost cell; False if it would not fit inside."""
    depth = np.asarray(distance_transform_cdt(np.pad(region, 1)))[1:-1, 1:-1]
    i, j = np.unravel_index(int(np.argmax(depth)), depth.shape)
    text = axes.text(float(figure.x[j]), float(figure.y[i]), escape_mathtext(name), fontsize=SMALL_PT, ha="center", va="center",
                     color=INK_COLOUR, zorder=5)
    box = text.get_window_extent().transformed(axes.transData.inverted())
    columns = (figure.x >= box.x0) & (figure.x <= box.x1)
    rows = (figure.y >= box.y0) & (figure.y <= box.y1)
    left, right = _edges(figure.x)
    if region[np.ix_(rows, columns)].all() and left < box.x0 and box.x1 < right:
        return True
    text.remove()
    return False


def _edges(values: np.ndarray) -> tuple[float, float]:
    half = float(values[1] - values[0]) / 2 if len(values) > 1 else 0.5
    return float(values[0]) - half, float(values[-1]) + half


def draw_gauges(axes: Axes, figure: GaugeFigure, language: str) -> None:
    """A track a number with its band; a number beyond the track is an arrow at its end."""
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(len(figure.gauges), 0.0)
    for k, gauge in enumerate(figure.gauges):
        colour, (low, high), middle = COLOURS[gauge.role], gauge.band, k + 0.52
        axes.text(0.0, k + 0.2, escape_mathtext(gauge.name(language)), fontsize=SMALL_PT, va="center", color=INK_COLOUR)
        said = f"{label_in_language(gauge.value, language)} · {gauge.verdict(language)}"
        axes.text(1.0, k + 0.2, escape_mathtext(said), fontsize=SMALL_PT, va="center", ha="right", color=INK_COLOUR)
        axes.plot([0.0, 1.0], [middle, middle], color=GRID_COLOUR, linewidth=5.0, solid_capstyle="butt", label="_")
        axes.plot([low, high], [middle, middle], color=COLOURS["muted"], linewidth=5.0, solid_capstyle="butt", alpha=0.5, label="_")
        if gauge.at is not None:
            mark = "<" if gauge.at < 0 else ">" if gauge.at > 1 else "o"
            axes.plot([min(max(gauge.at, 0.0), 1.0)], [middle], marker=mark, color=colour, markersize=5.5, linestyle="none",
                      clip_on=False, label="_")
        for at, words in zip(gauge.band, gauge.ends, strict=True):
            axes.text(at, k + 0.82, escape_mathtext(words), fontsize=SMALL_PT - 1, va="center",
                      ha="right" if at == 1 else "left" if at == 0 else "center", color=RULE_COLOUR)


def shade(figure: MatrixFigure) -> np.ndarray:
    """Colours (rows, columns, 3): white for zero, deeper in the colour of the cell's role by its depth."""
    full = np.array([to_rgb(COLOURS[role]) for role in figure.roles.ravel()]).reshape(*figure.matrix.shape, 3)
    return 1 - figure.fills[..., None] * (1 - full)


def draw_matrix(axes: Axes, figure: MatrixFigure, language: str) -> None:
    """Magnitudes of a matrix, with lines between its blocks."""
    matrix = np.asarray(figure.matrix, dtype=float)
    rows, columns = matrix.shape
    axes.imshow(shade(figure), interpolation="nearest", aspect="equal")
    axes.tick_params(length=0, top=False, bottom=False, labeltop=True, labelbottom=False,
                     labelsize=_fit(max(matrix.shape)))
    across, down = ([symbol(label_in_language(name, language)) for name in names] for names in (figure.columns, figure.rows))
    turn = 90 if columns > 6 or max(map(len, across), default=0) > 5 else 0
    axes.set_xticks(range(columns) if across else [], [escape_mathtext(n) for n in across], rotation=turn)
    axes.set_yticks(range(rows) if down else [], [escape_mathtext(n) for n in down])
    for spine in axes.spines.values():
        spine.set_visible(True)
    for edge in np.arange(0.5, max(rows, columns) - 1):
        if edge < rows - 1:
            axes.axhline(edge, color="white", linewidth=0.4)
        if edge < columns - 1:
            axes.axvline(edge, color="white", linewidth=0.4)
    for block in figure.blocks:
        axes.axhline(block - 0.5, color=COLOURS["reference"], linewidth=0.9)
        axes.axvline(block - 0.5, color=COLOURS["reference"], linewidth=0.9)


    for row in figure.lit:
        axes.add_patch(Rectangle((-0.5, row - 0.5), columns, 1.0, fill=False, edgecolor=COLOURS["reference"], linewidth=1.4, clip_on=False))
    for row, column, name in figure.block_names():
        axes.text(column - 0.5, row - 0.5, escape_mathtext(symbol(label_in_language(name, language))), ha="center", va="center",
                  color=INK_COLOUR, fontweight="bold")

    if figure.categories and not figure.blocks:
        size = _fit(2 * max(matrix.shape))
        for (i, j), entry in np.ndenumerate(matrix):
            axes.text(j, i, format_number(float(entry), ".3g"), fontsize=size, ha="center", va="center", color=INK_COLOUR)
        told = [Patch(color=COLOURS[role], alpha=FULL, label=escape_mathtext(name(language))) for name, role in figure.categories]
        axes.legend(handles=told, loc="upper center", bbox_to_anchor=(0.5, 0.0), frameon=False, ncols=len(told), borderpad=0.2)


def _fit(count: int) -> float:
    return min(SMALL_PT, 90.0 / max(count, 1))


def draw_table(axes: Axes, figure: TableFigure, language: str) -> None:
    """A table in a book's manner: a rule above, below the head, and at the foot; columns as wide as their words."""
    axes.set_axis_off()
    cells = [[c(language) for c in figure.columns],
             *([v if isinstance(v, str) else v(language) for v in row] for row in figure.rows)]
    lines = len(cells)
    axes.set_xlim(0, 1)
    axes.set_ylim(lines, 0)
    room = [max(text_width_em(row[k]) for row in cells) + 1.5 for k in range(len(figure.columns))]
    inches = float(axes.bbox.width) / float(axes.get_figure(root=True).dpi)  # type: ignore[union-attr]
    size = min(SMALL_PT, inches * 72 / max(sum(room), 1.0))
    starts = np.concatenate([[0.0], np.cumsum(room)]) / max(sum(room), inches * 72 / SMALL_PT)
    for i, row in enumerate(cells):
        for k, cell in enumerate(row):
            axes.text(starts[k] + 0.005, i + 0.55, escape_mathtext(cell), fontsize=size, va="center", color=INK_COLOUR,
                      fontweight="normal", fontstyle="normal")
    for at, thickness in ((0.0, 0.9), (1.0, 0.5), (float(lines), 0.9)):
        axes.plot([0, starts[-1]], [at, at], color=INK_COLOUR if thickness > 0.5 else RULE_COLOUR, linewidth=thickness, clip_on=False,
                  label="_")
