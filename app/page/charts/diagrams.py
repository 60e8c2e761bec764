"""Draw a block diagram as SVG, with the equations of its blocks.

`cursor.js` writes its values and widths where the clock stands, `diagram.js` lights block and equation.
"""

from __future__ import annotations

import html

from ...colours import COLOURS
from ...course.figures.diagram import SIZE, Block, DiagramFigure, Wire
from ...text import label_in_language
from ..words.prose import formula_html

BOX = f'class="ol-box" fill="{COLOURS["paper"]}" stroke="{COLOURS["chart-ink"]}"'
TITLE_ROOM = 22.0  # px above a diagram, for its title
THIN, THICK, RADIUS, HEAD = 1.0, 4.5, 9.0, 6.0  # px of a wire without signal and more of the largest one; of a sum; of an arrow


def diagram(figure: DiagramFigure, language: str) -> tuple[str, float]:
    """The drawing and its height."""
    out = "".join(_wire(wire, figure) for wire in figure.wires)
    out += "".join(f'<circle cx="{x}" cy="{y + TITLE_ROOM}" r="{RADIUS}" {BOX}/>' for x, y in figure.sums)
    out += "".join(_block(block, language) for block in figure.blocks)
    out += "".join(f'<text x="{x}" y="{y + TITLE_ROOM + 4}" text-anchor="middle">{html.escape(sign)}</text>'
                   for sign, (x, y) in figure.marks)
    return f'<g class="ol-diagram">{out}</g>', SIZE[1] + TITLE_ROOM


def equations(figure: DiagramFigure, language: str, hand: str) -> str:
    """The equations of the blocks, in rows, and the buttons of those that can be pressed."""
    rows = []
    for block in figure.blocks:
        button = "" if not block.press or not hand else (
            f'<button type="button" class="ol-do" data-to="{hand}" data-value="{block.id}">{html.escape(block.pressed(language))}</button>')
        if block.law or button:
            law = formula_html(block.law) if block.law else ""
            rows.append(f'<div class="ol-law" data-block="{block.id}" tabindex="0">{law}{button}</div>')
    return f'<div class="ol-laws">{"".join(rows)}</div>'


def _block(block: Block, language: str) -> str:
    left, top, wide, high = block.box
    top += TITLE_ROOM
    dashes = ' stroke-dasharray="5 4"' if block.off else ""
    return (f'<g data-block="{block.id}"><rect x="{left}" y="{top}" width="{wide}" height="{high}" rx="3" {BOX}{dashes}/>'
            f'<text x="{left + wide / 2}" y="{top + high / 2 + 4}" text-anchor="middle">'
            f"{html.escape(label_in_language(block.name, language))}</text></g>")


def _wire(wire: Wire, figure: DiagramFigure) -> str:
    moments, told = figure.moments, wire.said
    said, widths = [told[k] for k in moments], [THIN + THICK * float(share) for share in wire.shares[moments]]
    colour, out = COLOURS[wire.role], []
    for way in ([(x, y + TITLE_ROOM) for x, y in way] for way in wire.ways):
        (x0, y0), (x, y) = way[-2:]
        dx, dy = (x > x0) - (x < x0), (y > y0) - (y < y0)
        way = (*way[:-1], (x - HEAD * dx, y - HEAD * dy))
        out.append(f'<polyline points="{" ".join(f"{a:g},{b:g}" for a, b in way)}" fill="none"/>')
        head = f"{x:g},{y:g} {x - HEAD * dx + HEAD / 2 * dy:g},{y - HEAD * dy + HEAD / 2 * dx:g} " \
               f"{x - HEAD * dx - HEAD / 2 * dy:g},{y - HEAD * dy - HEAD / 2 * dx:g}"
        out.append(f'<polygon points="{head}" fill="{colour}" stroke="{colour}" stroke-width="1"/>')
    x, y = wire.at[0], wire.at[1] + TITLE_ROOM
    return (f'<g class="ol-wire" stroke="{colour}" stroke-width="{widths[0]:.1f}" data-said="{html.escape("|".join(said))}" '
            f'data-widths="{"|".join(f"{wide:.1f}" for wide in widths)}">{"".join(out)}'
            f'<text x="{x:g}" y="{y:g}" stroke="none">{html.escape(said[0])}</text></g>')
