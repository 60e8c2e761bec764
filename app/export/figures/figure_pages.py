"""Draw each figure as an SVG without title and caption, and tell where time runs in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Page

from ...course.figures.records import Figure, LineFigure
from .figure import CELL, DPI, SUFFIXES, cell_of, place_axes
from .style import export_style

__all__ = ["FigureImage", "TimeSpan", "draw_figure_images"]

EDGE_IN = 0.06  # inches of white above and below


@dataclass(frozen=True)
class TimeSpan:
    """The part of a plate that time runs over: its edges as shares of the plate's width and height, and the moments there."""

    left: float
    right: float
    top: float
    bottom: float
    begin: float
    end: float


@dataclass(frozen=True, eq=False)
class FigureImage:
    """A figure's picture as SVG (words as outlines), with the words that belong to it; `span` where it is over time."""

    figure: Figure
    svg: bytes
    span: TimeSpan | None


def draw_figure_images(figures: Sequence[Figure], language: str = "en") -> Iterator[FigureImage]:
    """A plate a figure, drawn one by one on no ground. The same records give the same bytes."""
    for figure in figures:
        with export_style(language):
            cell, out = cell_of(figure, language), BytesIO()
            size = (CELL, cell.above + cell.axes + cell.below + 2 * EDGE_IN)
            page = Page(figsize=size, dpi=DPI)
            FigureCanvasAgg(page)
            axes = place_axes(page, size, cell, 0.0, cell.below + EDGE_IN, language)
            page.savefig(out, format="svg", dpi=DPI, transparent=True, metadata=SUFFIXES[".svg"]["metadata"])
            yield FigureImage(figure, out.getvalue(), _span(axes, figure))


def _span(axes: Axes, figure: Figure) -> TimeSpan | None:
    if not isinstance(figure, LineFigure) or figure.log_x:
        return None
    box, (begin, end) = axes.get_position(), axes.get_xlim()
    return TimeSpan(box.x0, box.x1, 1 - box.y1, 1 - box.y0, begin, end)
