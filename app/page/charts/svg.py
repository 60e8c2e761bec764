"""Draw planes, matrices, maps and tables as SVG or HTML in both languages."""

from __future__ import annotations

import html
import json
import math
import re
from typing import assert_never

import numpy as np

from ...colours import COLOURS, rgb
from ...course.figures.records import (
    Curve,
    DiagramFigure,
    Figure,
    GaugeFigure,
    LineFigure,
    MapFigure,
    MatrixFigure,
    PlaneFigure,
    TableFigure,
    finite,
)
from ...course.guiding.questions import DrawnQuestion
from ...text import format_number, label_in_language
from ..words.prose import with_minus
from .axes import ROW_HEIGHT_PX, Axes, H, W, clear_of_marks
from .diagrams import diagram, equations
from .gauges import gauges
from .matrices import matrix
from .text_layout import (
    LARGE_PRINT_PX,
    SVG_DASHES,
    WORDS_PX,
    Box,
    Name,
    curve_key,
    fold_lines,
    place_along_curves,
    place_beside_mark,
    text_width,
)

TIED = 4.0  # letters: so little in a cell of a table stands in one line
BETWEEN = "\N{NO-BREAK SPACE}·\N{NO-BREAK SPACE}"  # between the numbers of a cell, which part in large print alone, where they must
MOST_NAMES, NAME_COLOUR_SHARE = (
    4,
    0.66,
)  # names of curves that stand beside them, more stand in a key; how much of a curve's colour is its name's
BOLD = 1.08  # how much wider bold words are
CELL_OPACITY = 0.75  # of the cells of a map
LEAST_BAR_PX = 2.5  # px that a bar is high at least
TITLE_PX = 14.0  # px of a drawing's title; in large print it is as large as its other words
BARS = re.compile("▮+")  # the level of a number in a table: a bar as many parts long
TIMES_TEN = "·10"  # a number parts before its power of ten as those of a cell do


def draw(figure: Figure, language: str, large: bool = False, high: float = H, hand: str = "") -> str:
    """The HTML of a figure that is not a chart over time or frequency, in usual or large print; `high` is how high a plane is or a
    map, beside the width `W` that all drawings have, `hand` the widget that hears presses on the figure."""
    match figure:
        case PlaneFigure():
            return _svg(_plane(figure, language, large, high), figure, language, large)
        case MatrixFigure():
            return _svg(matrix(figure, language, large), figure, language, large)
        case MapFigure():
            return _svg(_map(figure, language, large, high), figure, language, large)
        case TableFigure():
            return _table(figure, language)
        case DiagramFigure():
            drawn = _svg(diagram(figure, language), figure, language, large)
            return f'<div class="ol-drawn">{drawn}{equations(figure, language, hand)}</div>'
        case GaugeFigure():
            return _svg(gauges(figure, language, large), figure, language, large)
        case LineFigure():
            raise TypeError(f"The figure {figure.id} runs over time or frequency; uPlot draws it.")
        case _:
            assert_never(figure)


def _svg(drawn: tuple[str, float], figure: Figure, language: str, large: bool) -> str:
    """A drawing under its title, which stands in lines where it is too long for one."""
    (body, height), title = drawn, figure.title(language)
    size = LARGE_PRINT_PX if large else TITLE_PX
    lines = fold_lines(title, W / (BOLD * size)).split("\n")
    more = ROW_HEIGHT_PX * (len(lines) - 1)
    said = "".join(
        f'<text x="{W / 2}" y="{16 + k * ROW_HEIGHT_PX - more:.1f}" text-anchor="middle" font-size="{size:.1f}" font-weight="600">'
        f"{html.escape(line)}</text>"
        for k, line in enumerate(lines)
    )
    return (
        f'<div class="ol-figure" data-figure="{figure.id}"><svg viewBox="0 {0 - more:.0f} {W} {height + more:.0f}" role="img" '
        f'aria-label="{html.escape(title)}" font-family="sans-serif" font-size="{LARGE_PRINT_PX if large else WORDS_PX:g}" '
        f'fill="{COLOURS["chart-ink"]}">'
        f"{said}{body}</svg></div>"
    )


def axes_of_plane(figure: PlaneFigure, language: str, high: float) -> Axes:
    """Where the points of a plane stand in its drawing."""
    return Axes(
        clear_of_marks(figure.x_range, [p.x for p in figure.points], W),
        clear_of_marks(figure.y_range, [p.y for p in figure.points], high),
        figure.equal,
        (label_in_language(figure.x_label, language), label_in_language(figure.y_label, language)),
        figure.powers,
        high,
        tuple((at, name(language)) for at, name in figure.names),
    )


def _plane(figure: PlaneFigure, language: str, large: bool, high: float) -> tuple[str, float]:
    axes, out = axes_of_plane(figure, language, high), []
    if figure.unstable and axes.x[1] > 0:
        left, _ = axes.at(max(0.0, axes.x[0]), 0)
        out.append(f'<rect {axes.area(left)} fill="{COLOURS["unstable"]}"/>')
    out.append(axes.draw())
    out.append(f'<clipPath id="clip-{figure.id}"><rect {axes.area()}/></clipPath>'
               f'<g clip-path="url(#clip-{figure.id})">')
    drawn = []
    for curve in figure.curves:
        xs = np.arange(len(curve.y)) if curve.x is None else curve.x
        path = [axes.at(float(a), float(b)) for a, b in zip(finite(xs, 1e6), finite(curve.y, 1e6), strict=True)]
        bar = bool(figure.names) and len(path) == 2 and path[0][0] == path[1][0]
        if bar and abs(path[1][1] - path[0][1]) < LEAST_BAR_PX:
            path[1] = (path[1][0], path[0][1] - LEAST_BAR_PX)  # a bar of height zero is seen to stand there
        drawn.append(path)
        if bar and curve.dash != "solid":
            out.append(_outline(path, curve))
            continue
        points = " ".join(f"{px:.1f},{py:.1f}" for px, py in path)
        out.append(f'<polyline points="{points}" fill="none" stroke="{COLOURS[curve.role]}" '
                   f'stroke-width="{curve.width}"{SVG_DASHES[curve.dash]}/>')
    out.append("</g>")
    if figure.id == "question" and figure.names:
        out += _sizes_of_bars([(path, 10.0 ** y if figure.powers else y, curve.dash != "solid")
                               for path, curve in zip(drawn, figure.curves, strict=True)
                               if path[0][0] == path[-1][0] and math.isfinite(y := float(curve.y[-1]))])
    out += [_mark(*axes.held(p.x, p.y), COLOURS[p.role], p.mark) for p in figure.points]
    marks = [(*axes.held(p.x, p.y), p.name(language)) for p in figure.points if math.isfinite(p.x + p.y)]
    names, taken = _names(marks, np.array([at for path in drawn for at in path], dtype=float).reshape(-1, 2), axes.frame)
    told = {curve.entry(language): k for k, curve in reversed(list(enumerate(figure.curves))) if curve.entry(language)}
    if len(told) <= MOST_NAMES and not figure.names:  # bars leave no room for words
        first = sorted(told.values())
        words = [figure.curves[k].entry(language) for k in first]
        places = place_along_curves([np.array(drawn[k], dtype=float).reshape(-1, 2) for k in first], words, axes.frame, taken)
        names += "".join(_name(at, name, figure.curves[k].role) for k, name, at in zip(first, words, places, strict=True) if at)
        return "".join(out) + names, axes.height
    below, more = curve_key([(c.entry(language), COLOURS["muted" if c.pin.id else c.role], c.dash) for c in figure.curves], W, axes.height,
                      patches=bool(figure.names), large=large)
    return "".join(out) + names + below, axes.height + more


def _outline(path: list[tuple[float, float]], bar: Curve) -> str:
    """A bar that is only supposed: its edge, dashed."""
    (x, foot), (_, top) = path
    return (f'<rect x="{x - bar.width / 2:.1f}" y="{min(foot, top):.1f}" width="{bar.width:g}" height="{abs(foot - top):.1f}" fill="none" '
            f'stroke="{COLOURS[bar.role]}" stroke-width="2"{SVG_DASHES[bar.dash]}/>')


def _sizes_of_bars(bars: list[tuple[list[tuple[float, float]], float, bool]]) -> list[str]:
    """The number that each bar shows, above its end, below that of a negative one; of a guess none where it would lie on another."""
    taken, out = list[Box](), list[str]()
    for ((x, foot), (_, top)), value, _ in sorted(bars, key=lambda each: each[-1]):
        said, y = with_minus(format_number(value, ".3g")), top - 4 if top <= foot else top + 13
        half = text_width(said, WORDS_PX) / 2
        place = Box(x - half, y - WORDS_PX, x + half, y)
        if not any(place.meets(other) for other in taken):
            taken.append(place)
            out.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="middle" paint-order="stroke" stroke="{COLOURS["paper"]}" '
                       f'stroke-width="3">{html.escape(said)}</text>')
    return out


def _names(marks: list[tuple[float, float, str]], drawn: np.ndarray, frame: Box) -> tuple[str, list[Box]]:
    """The names of marks, each beside its own and clear of the others, and what marks and names cover."""
    taken = [Box(x - 6, y - 6, x + 6, y + 6) for x, y, _ in marks]
    out = []
    for x, y, words in marks:
        if words:
            at = place_beside_mark(x, y, words, frame, taken, drawn)
            taken.append(at.box)
            out.append(_name(at, words, ""))
    return "".join(out), taken


def _name(at: Name, words: str, role: str) -> str:
    """Words with a white rim, in the colour of a curve, darkened, if they are its name."""
    colour = f' fill="{_dark(COLOURS[role])}" font-weight="600"' if role else ""
    return (f'<text x="{at.x:.1f}" y="{at.y:.1f}" text-anchor="{at.anchor}" paint-order="stroke" stroke="{COLOURS["paper"]}" '
            f'stroke-width="3"{colour}>{html.escape(words)}</text>')


def _dark(colour: str) -> str:
    """A colour #rrggbb nearer to black, to read words in."""
    return "#" + "".join(f"{round(NAME_COLOUR_SHARE * part):02x}" for part in rgb(colour))


def _mark(x: float, y: float, colour: str, mark: str) -> str:
    if not (math.isfinite(x) and math.isfinite(y)):
        return ""
    return {
        "cross": f'<path d="M{x - 5:.1f} {y - 5:.1f}l10 10m-10 0l10 -10" stroke="{colour}" stroke-width="2.6"/>',
        "circle": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="7" fill="none" stroke="{colour}" stroke-width="2.2"/>',
        "ring": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="9.5" fill="none" stroke="{colour}" stroke-width="2.2"/>',
        "hollow": f'<path d="M{x - 5:.1f} {y:.1f}l5 -5l5 5l-5 5z" fill="none" stroke="{colour}" stroke-width="1.4"/>',
        "dot": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>',
        "up": f'<path d="M{x - 4:.1f} {y + 3:.1f}h8l-4 -8z" fill="{colour}"/>',
        "bolt": f'<path d="M{x - 6:.1f} {y:.1f}l3 -5.2h6l3 5.2l-3 5.2h-6z" fill="{COLOURS["bolt"]}"/>',
    }[mark]


def _map(figure: MapFigure, language: str, large: bool, high: float) -> tuple[str, float]:
    axes = Axes(
        _span(figure.x),
        _span(figure.y),
        False,
        (label_in_language(figure.x_label, language), label_in_language(figure.y_label, language)),
        "",
        high,
    )
    out = []
    dx, dy = (_step(v) for v in (figure.x, figure.y))
    for k, (_, role) in enumerate(figure.categories):
        path = []
        for i, j in np.argwhere(figure.values == k):
            x0, y0 = axes.at(float(figure.x[j]) - dx / 2, float(figure.y[i]) + dy / 2)
            x1, y1 = axes.at(float(figure.x[j]) + dx / 2, float(figure.y[i]) - dy / 2)
            path.append(f"M{x0:.1f} {y0:.1f}H{x1:.1f}V{y1:.1f}H{x0:.1f}z")
        out.append(f'<path d="{"".join(path)}" fill="{COLOURS[role]}" fill-opacity="{CELL_OPACITY:g}"/>')
    out.append(axes.draw())
    if figure.marked is not None:
        out.append(_mark(*axes.held(*figure.marked), COLOURS["reference"], "circle"))
    words, more = curve_key([(name(language), COLOURS[role], "solid") for name, role in figure.categories], W, axes.height, patches=True,
                            large=large, solid=CELL_OPACITY)
    return "".join(out) + words, axes.height + more


def _step(values: np.ndarray) -> float:
    return float(values[1] - values[0]) if len(values) > 1 else 1.0


def _span(values: np.ndarray) -> tuple[float, float]:
    half = _step(values) / 2
    return float(values[0]) - half, float(values[-1]) + half


def _table(figure: TableFigure, language: str) -> str:
    def said(value: object) -> str:
        return with_minus(value if isinstance(value, str) else value(language))  # type: ignore[operator]

    def cell(value: object, kind: str) -> str:
        words = said(value)
        tied = ' class="ol-tied"' if text_width(words, 1.0) <= TIED and TIMES_TEN not in words else ""
        parted = (
            html.escape(words)
            .replace(TIMES_TEN, TIMES_TEN[0] + "<wbr>" + TIMES_TEN[1:])
            .replace(BETWEEN, BETWEEN[:-1] + "<wbr>" + BETWEEN[-1])
        )
        drawn = BARS.sub(lambda bar: f'<i class="ol-level" style="--parts:{len(bar[0])}"></i>', parted)
        return f"<{kind}{tied}>{drawn}</{kind}>"
    head = "".join(cell(c, "th") for c in figure.columns)
    body = "".join("<tr>" + "".join(cell(v, "td") for v in row) + "</tr>" for row in figure.rows)
    return (f'<div class="ol-figure" data-figure="{figure.id}"><table class="ol-table"><caption>'
            f"{html.escape(figure.title(language))}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>")


def sketch_frame(question: DrawnQuestion, figure: PlaneFigure, drawn: str, high: float, language: str, key: str, how: str,
                 send: str) -> str:
    """The figure as it is `drawn`, open to a hand, with what to do and the button `send`; in this browser its name is `key`."""
    axes = axes_of_plane(figure, language, high)
    columns = [round(axes.at(x, 0.0)[0], 1) for x in question.columns]
    told = {"question": key, "columns": columns, "top": axes.frame.top, "foot": axes.frame.bottom, "bars": question.bars}
    name = html.escape(how, quote=True)
    inside = '<path class="ol-sketched" fill="none" d=""/><circle class="ol-caret" r="5"/></svg>'
    drawn = drawn.replace("</svg>", inside, 1).replace('role="img"', f'role="application" tabindex="0" aria-description="{name}"', 1)
    return (f'<div class="ol-sketch" data-sketch="{html.escape(json.dumps(told), quote=True)}">{drawn}<p class="ol-number">'
            f'<span class="ol-note">{name}</span>{send}</p></div>')
