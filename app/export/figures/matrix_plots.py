"""Draw matrices as heat maps and tables with rules on matplotlib axes."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch, Rectangle

from ...colours import COLOURS
from ...course.figures.matrix_figure import FULL
from ...course.figures.records import MatrixFigure, TableFigure
from ...text import format_number, label_in_language, symbol
from .line_breaks import text_width_em
from .style import INK_COLOUR, RULE_COLOUR, SMALL_PT, escape_mathtext

__all__ = ["draw_matrix", "draw_table", "shade"]


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
