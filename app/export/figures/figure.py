"""Write figures as PNG, SVG or PDF, the same bytes for the same records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import Any, assert_never

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Page
from matplotlib.patches import Circle, Rectangle

from ...colours import COLOURS
from ...course.figures.diagram import SIZE
from ...course.figures.records import DiagramFigure, Figure, GaugeFigure, LineFigure, MapFigure, MatrixFigure, PlaneFigure, TableFigure
from ...text import label_in_language
from .panels import draw_gauges, draw_lines, draw_map, draw_matrix, draw_plane, draw_table
from .style import INK_COLOUR, SMALL_PT, TITLE_PT, escape_mathtext, export_style, wrap

__all__ = [
    "SUFFIXES",
    "Cell",
    "ExportError",
    "cell_of",
    "draw_diagram",
    "draw_page",
    "figures_as",
    "letter_of",
    "place",
    "place_axes",
    "save_figures",
]

# What would differ from one run to the next is left out of each kind of file.
SUFFIXES: Mapping[str, dict[str, Any]] = MappingProxyType({
    ".png": {"metadata": {"Software": "Observer Lab"}},
    ".svg": {"metadata": {"Date": None, "Creator": "Observer Lab"}},
    ".pdf": {"metadata": {"CreationDate": None, "Creator": "Observer Lab", "Producer": None}},
})
ABOUT: Mapping[str, str] = MappingProxyType({"png": "Description", "svg": "Description", "pdf": "Subject"})
DPI = 200
CELL, MARGIN = 3.55, 0.12  # width of a figure with its words, edge of the page, in inches
LEFT_IN, RIGHT_IN, TOP_IN, BOTTOM_IN = 0.58, 0.14, 0.26, 0.36  # room for numbers and words around the axes, in inches
CURVES_HEIGHT_IN, LINE_HEIGHT_IN, ROW_HEIGHT_IN = 1.72, 0.125, 0.165  # height of axes, of a caption's line, of a table's row, in inches
COLUMN_NAMES, KEY_IN, GAUGE_HEIGHT_IN = 0.34, 0.2, 0.42  # inches over a matrix for its columns' names, below it for its key; of a gauge
THIN, THICK, RADIUS = 0.6, 1.8, 9.0  # pt of a wire without signal and more of the largest one; units of the circle of a sum


class ExportError(ValueError):
    """A file that cannot be written as asked; the message is one sentence."""


@dataclass(frozen=True)
class Cell:
    """What one figure needs: inches for its axes and what is around them, and its caption in lines."""

    figure: Figure
    axes: float
    above: float
    below: float
    caption: tuple[str, ...]
    left: float = LEFT_IN

    @property
    def height(self) -> float:
        return TOP_IN + self.above + self.axes + self.below + LINE_HEIGHT_IN * len(self.caption) + 0.16


def save_figures(figures: Sequence[Figure], path: str | Path, language: str = "en", token: str = "") -> None:
    """Write all figures on one page: PNG (200 dpi), SVG (text as outlines) or PDF (fonts embedded), by the suffix.

    `language` is one of `observer_lab.text.languages()`; the token of the state stands among what the file says of itself. The same
    records give the same bytes. Warns (MissingFontWarning) where Chinese is asked for and no font holds it. Raises
    ExportError for another suffix or no figures, OSError if the file cannot be written.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise ExportError(f"A figure is written as {', '.join(SUFFIXES)}; {path.name} ends in none of these.")
    path.write_bytes(figures_as(figures, kind[1:], language, token))


def figures_as(figures: Sequence[Figure], kind: str, language: str = "en", token: str = "") -> bytes:
    """All figures on one page as "png", "svg" or "pdf", with the token of their state among what the file says of itself.

    Raises ExportError without figures.
    """
    metadata = dict(SUFFIXES[f".{kind}"]["metadata"])
    if token:
        metadata[ABOUT[kind]] = token
    out = BytesIO()
    with export_style(language):
        _draw(figures, language).savefig(out, format=kind, dpi=DPI, metadata=metadata)
    return out.getvalue()


def draw_page(figures: Sequence[Figure], language: str = "en") -> Page:
    """The page as a matplotlib figure, for tests and notebooks. Raises ExportError without figures."""
    with export_style(language):
        return _draw(figures, language)


def _draw(figures: Sequence[Figure], language: str) -> Page:
    if not figures:
        raise ExportError("There is no figure to draw.")
    across = 1 if len(figures) == 1 else 2
    cells = [cell_of(figure, language) for figure in figures]
    rows = [cells[i:i + across] for i in range(0, len(cells), across)]
    heights = [max(cell.height for cell in row) for row in rows]
    size = (across * CELL + 2 * MARGIN, sum(heights) + 2 * MARGIN)
    page = Page(figsize=size, dpi=DPI, facecolor="white")
    FigureCanvasAgg(page)
    top = size[1] - MARGIN
    for i, (row, height) in enumerate(zip(rows, heights, strict=True)):
        for j, cell in enumerate(row):
            letter = "" if len(cells) == 1 else f"({letter_of(i * across + j)})  "
            place(page, size, cell, MARGIN + j * CELL, top, letter, language)
        top -= height
    return page


def cell_of(figure: Figure, language: str) -> Cell:
    """The room that a figure takes, with its words."""
    caption = tuple(wrap(figure.caption(language), (CELL - 0.2) * 72 / SMALL_PT))
    match figure:
        case TableFigure():
            return Cell(figure, ROW_HEIGHT_IN * (len(figure.rows) + 1), 0.04, 0.06, caption, left=0.1)
        case MatrixFigure():
            rows, columns = figure.matrix.shape
            wide = CELL - LEFT_IN - RIGHT_IN
            return Cell(figure, wide * min(1.0, rows / max(columns, 1)) * 0.86,
                        COLUMN_NAMES if figure.columns else 0.04, 0.06 if figure.blocks or not figure.categories else KEY_IN, caption)
        case DiagramFigure():
            return Cell(figure, CELL * SIZE[1] / SIZE[0], 0.04, 0.06, caption, left=0.1)
        case GaugeFigure():
            return Cell(figure, GAUGE_HEIGHT_IN * len(figure.gauges), 0.04, 0.06, caption, left=0.14)
        case LineFigure() | PlaneFigure() | MapFigure():
            return Cell(figure, CURVES_HEIGHT_IN, 0.0, BOTTOM_IN, caption)
        case _:
            assert_never(figure)


def place(page: Page, size: tuple[float, float], cell: Cell, left: float, top: float, letter: str,
           language: str) -> None:
    """Title, axes and caption of one figure, placed in inches from the upper left corner of its cell."""
    wide, high = size
    title = letter + escape_mathtext(cell.figure.title(language))
    page.text((left + 0.05) / wide, (top - 0.04) / high, title, fontsize=TITLE_PT, va="top", color=INK_COLOUR)
    bottom = top - TOP_IN - cell.above - cell.axes
    place_axes(page, size, cell, left, bottom, language)
    for k, line in enumerate(cell.caption):
        page.text((left + 0.05) / wide, (bottom - cell.below - 0.03 - k * LINE_HEIGHT_IN) / high, escape_mathtext(line), fontsize=SMALL_PT,
                  va="top", color=INK_COLOUR)


def place_axes(page: Page, size: tuple[float, float], cell: Cell, left: float, bottom: float, language: str) -> Axes:
    """The axes of one figure alone, drawn."""
    wide, high = size
    axes = page.add_axes(((left + cell.left) / wide, bottom / high, (CELL - cell.left - RIGHT_IN) / wide, cell.axes / high))
    axes.set_gid(cell.figure.id)
    _draw_kind(axes, cell.figure, language)
    return axes


def _draw_kind(axes: Axes, figure: Figure, language: str) -> None:
    match figure:
        case LineFigure():
            draw_lines(axes, figure, language)
        case PlaneFigure():
            draw_plane(axes, figure, language)
        case MapFigure():
            draw_map(axes, figure, language)
        case MatrixFigure():
            draw_matrix(axes, figure, language)
        case TableFigure():
            draw_table(axes, figure, language)
        case DiagramFigure():
            draw_diagram(axes, figure, language)
        case GaugeFigure():
            draw_gauges(axes, figure, language)
        case _:
            assert_never(figure)


def letter_of(index: int) -> str:
    """a … z, then aa, ab …"""
    return (letter_of(index // 26 - 1) if index >= 26 else "") + chr(ord("a") + index % 26)


def draw_diagram(axes: Axes, figure: DiagramFigure, language: str) -> None:
    """Blocks, wires as thick as their signals are at the start, and the names of both."""
    axes.set_xlim(0.0, SIZE[0])
    axes.set_ylim(SIZE[1], 0.0)
    axes.axis("off")
    for wire in figure.wires:
        wide, colour = THIN + THICK * float(wire.shares[0]), COLOURS[wire.role]
        for way in wire.ways:
            axes.plot(*zip(*way[:-1], strict=True), color=colour, linewidth=wide, solid_joinstyle="miter")
            look = {"arrowstyle": "-|>", "color": colour, "linewidth": wide, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", way[-1], way[-2], arrowprops=look)
        axes.text(*wire.at, escape_mathtext(wire.said[0]), fontsize=SMALL_PT, color=INK_COLOUR)
    for block in figure.blocks:
        left, top, wide, high = block.box
        axes.add_patch(Rectangle((left, top), wide, high, facecolor="white", edgecolor=INK_COLOUR, linewidth=0.8,
                                 linestyle="--" if block.off else "-"))
        axes.text(left + wide / 2, top + high / 2, escape_mathtext(label_in_language(block.name, language)), fontsize=SMALL_PT, ha="center",
                  va="center", color=INK_COLOUR)
    for x, y in figure.sums:
        axes.add_patch(Circle((x, y), RADIUS, facecolor="white", edgecolor=INK_COLOUR, linewidth=0.8))
    for sign, (x, y) in figure.marks:
        axes.text(x, y, sign, fontsize=SMALL_PT, ha="center", va="center", color=INK_COLOUR)
