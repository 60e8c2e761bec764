"""Draw a block diagram on matplotlib axes, at the start of its run."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from ...colours import COLOURS
from ...course.figures.diagram import SIZE, DiagramFigure
from ...text import label_in_language
from .style import INK_COLOUR, SMALL_PT, escape_mathtext

__all__ = ["draw_diagram"]

THIN, THICK, RADIUS = 0.6, 1.8, 9.0  # pt of a wire without signal and more of the largest one; units of the circle of a sum


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
