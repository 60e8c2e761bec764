"""Draw matrices as heat maps and tables with rules on matplotlib axes."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from ...colours import COLOURS
from ...course.figures.records import MatrixFigure, TableFigure, finite
from ...text import label_in_language, symbol
from .line_breaks import text_width_em
from .style import INK_COLOUR, RULE_COLOUR, SMALL_PT, escape_mathtext

__all__ = ["draw_matrix", "draw_table", "shade"]

ZERO_ENTRY_RTOL = 1e-9  # of the largest entry: below it an entry is drawn as zero, white
SHADE_DECADES = 6.0  # decades of magnitude between palest and darkest


def shade(matrix: np.ndarray) -> np.ndarray:
    """Colours (rows, columns, 3): white for zero, deeper in the plant's blue with the logarithm of the magnitude."""
    size = np.abs(finite(matrix))
    share = size / (float(size.max(initial=0.0)) or 1.0)
    with np.errstate(divide="ignore"):
        depth = 0.15 + 0.85 * np.maximum(0.0, 1 + np.log10(share) / SHADE_DECADES)
    depth = np.where(share < ZERO_ENTRY_RTOL, 0.0, depth)[..., None]
    return 1 - depth * (1 - np.array(to_rgb(COLOURS["plant"])))


def draw_matrix(axes: Axes, figure: MatrixFigure, language: str) -> None:
    """Magnitudes of a matrix, with lines between its blocks."""
    matrix = np.asarray(figure.matrix, dtype=float)
    rows, columns = matrix.shape
    axes.imshow(shade(matrix), interpolation="nearest", aspect="equal")
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
