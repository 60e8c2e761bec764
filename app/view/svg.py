"""Planes, matrices, maps and tables as SVG or HTML: small, sharp, and legible in both languages."""

from __future__ import annotations

import html
import math

import numpy as np

from ..lesson.figures import COLOURS, Figure, MapFigure, MatrixFigure, PlaneFigure, TableFigure, finite
from ..lesson.scales import decades
from ..text import symbol, wording
from .lettering import DASHES, LARGE, SIZE, Box, Name, along, beside, folded, key, width
from .prose import with_minus
from .ticks import ticks

W, H = 360, 250
LEFT, RIGHT, TOP, BOTTOM = 56, 12, 28, 36
FRAME = Box(LEFT, TOP, W - RIGHT, H - BOTTOM)
# of the names of axes: the height of a line in the tallest fonts, what of it rises above the foot of letters, px to the numbers
ROW, RISE, CLEAR = 1.45 * LARGE, 1.16 * LARGE, 8.0
AWAY = 5.0  # px from the numbers to the frame
TIED = 4.0  # letters: so little in a cell of a table stands in one line
BETWEEN = "\N{NO-BREAK SPACE}·\N{NO-BREAK SPACE}"  # between the numbers of a cell, which part in large print alone, where they must
MOST_NAMES, INK = 4, 0.66  # names of curves that stand beside them, more stand in a key; how much of a curve's colour is its name's
TALLEST_CELL, ROOM_FOR_ENTRY, SMALLEST = 48, 38, 7.5  # of a matrix: height and width of cells, font size of names, in px


def draw(figure: Figure, language: str) -> str:
    """The HTML of a figure that is not a chart over time or frequency."""
    if isinstance(figure, PlaneFigure):
        return _svg(_plane(figure, language), figure.title(language), figure.id)
    if isinstance(figure, MatrixFigure):
        return _svg(_matrix(figure, language), figure.title(language), figure.id)
    if isinstance(figure, MapFigure):
        return _svg(_map(figure, language), figure.title(language), figure.id)
    if isinstance(figure, TableFigure):
        return _table(figure, language)
    raise TypeError(f"{type(figure).__name__} is drawn by uPlot")


def _svg(drawn: tuple[str, float], title: str, name: str) -> str:
    body, height = drawn
    return (f'<div class="ol-figure" data-figure="{name}"><svg viewBox="0 0 {W} {height:.0f}" role="img" '
            f'aria-label="{html.escape(title)}" font-family="sans-serif" font-size="11" fill="#333a44">'
            f'<text x="{W / 2}" y="16" text-anchor="middle" font-size="{min(13.0, 13.0 * W / max(width(title, 14.0), 1.0)):.1f}" '
            f'font-weight="600">{html.escape(title)}</text>{body}</svg></div>')


class _Axes:
    """Maps a range of the plane to the drawing area and draws grid, numbers and names.

    Both names have the room that large print asks for: beside the numbers, and in lines where one would not hold them.
    """

    def __init__(self, x: tuple[float, float], y: tuple[float, float], equal: bool, names: tuple[str, str], powers: str = "") -> None:
        self._powers, self._upright = powers, folded(names[1], (H - TOP - BOTTOM) / LARGE).split("\n")
        self.left = FRAME.left
        self._fit(x, y, equal)
        widest = max((width(name, LARGE) for _, name in self._levels()), default=0.0)
        self.left = max(self.left, len(self._upright) * ROW + CLEAR + widest + AWAY)
        self._fit(x, y, equal)
        self._across = folded(names[0], (W - RIGHT - self.left) / LARGE).split("\n")
        self.height = H + ROW * (len(self._across) - 1)

    def _fit(self, x: tuple[float, float], y: tuple[float, float], equal: bool) -> None:
        across, up = W - self.left - RIGHT, H - TOP - BOTTOM
        if equal:
            scale = max((x[1] - x[0]) / across, (y[1] - y[0]) / up)
            cx, cy = sum(x) / 2, sum(y) / 2
            x = (cx - scale * across / 2, cx + scale * across / 2)
            y = (cy - scale * up / 2, cy + scale * up / 2)
        self.x, self.y = x, y
        self._sx, self._sy = across / (x[1] - x[0]), up / (y[1] - y[0])

    def _levels(self) -> list[tuple[float, str]]:
        return _numbers(*self.y, 5, "y" in self._powers)

    @property
    def frame(self) -> Box:
        """The drawing area."""
        return Box(self.left, TOP, W - RIGHT, H - BOTTOM)

    def at(self, x: float, y: float) -> tuple[float, float]:
        return self.left + (x - self.x[0]) * self._sx, H - BOTTOM - (y - self.y[0]) * self._sy

    def held(self, x: float, y: float) -> tuple[float, float]:
        """The pixel of a point, or the nearest one inside the frame."""
        px, py = self.at(x, y)
        return min(max(px, self.left), W - RIGHT), min(max(py, TOP), H - BOTTOM)

    def area(self, left: float = 0.0) -> str:
        """Where the drawing area is, from a pixel on, as an element says it."""
        begin = max(left, self.left)
        return f'x="{begin:.1f}" y="{TOP}" width="{W - RIGHT - begin:.1f}" height="{H - TOP - BOTTOM}"'

    def draw(self) -> str:
        out = [f'<rect {self.area()} fill="none" stroke="#c9ced6"/>']
        for v, name in _numbers(*self.x, 6, "x" in self._powers):
            px, _ = self.at(v, 0)
            out.append(f'<line x1="{px:.1f}" x2="{px:.1f}" y1="{TOP}" y2="{H - BOTTOM}" stroke="#e8ebf0"/>'
                       f'<text x="{px:.1f}" y="{H - BOTTOM + 14}" text-anchor="middle">{name}</text>')
        for v, name in self._levels():
            _, py = self.at(0, v)
            out.append(f'<line x1="{self.left:.1f}" x2="{W - RIGHT}" y1="{py:.1f}" y2="{py:.1f}" stroke="#e8ebf0"/>'
                       f'<text x="{self.left - AWAY:.1f}" y="{min(py + 4, H - BOTTOM):.1f}" text-anchor="end">{name}</text>')
        middle = (self.left + W - RIGHT) / 2
        out += [f'<text x="{middle:.1f}" y="{H - 6 + k * ROW:.1f}" text-anchor="middle">{html.escape(line)}</text>'
                for k, line in enumerate(self._across)]
        out += [f'<text transform="translate({RISE + k * ROW:.1f} {(TOP + H - BOTTOM) / 2}) rotate(-90)" text-anchor="middle">'
                f"{html.escape(line)}</text>" for k, line in enumerate(self._upright)]
        return "".join(out)


def _numbers(low: float, high: float, most: int, powers: bool) -> list[tuple[float, str]]:
    """Places and names of the numbers of an axis; over one of exponents the powers of ten."""
    if powers:
        return [(math.log10(value), name) for value, name in zip(*decades(10.0**low, 10.0**high, most), strict=True)]
    return [(v, f"{v:.6g}".replace("-", "−")) for v in ticks(low, high, most)]


def _plane(figure: PlaneFigure, language: str) -> tuple[str, float]:
    axes = _Axes(figure.x_range, figure.y_range, figure.equal, (wording(figure.x_label, language), wording(figure.y_label, language)),
                 figure.powers)
    out = []
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
        drawn.append(path)
        points = " ".join(f"{px:.1f},{py:.1f}" for px, py in path)
        out.append(f'<polyline points="{points}" fill="none" stroke="{COLOURS[curve.role]}" '
                   f'stroke-width="{curve.width}"{DASHES[curve.dash]}/>')
    out.append("</g>")
    out += [_mark(*axes.held(p.x, p.y), COLOURS[p.role], p.mark) for p in figure.points]
    marks = [(*axes.held(p.x, p.y), p.name(language)) for p in figure.points if math.isfinite(p.x + p.y)]
    names, taken = _names(marks, np.array([at for path in drawn for at in path], dtype=float).reshape(-1, 2), axes.frame)
    told = {curve.entry(language): k for k, curve in reversed(list(enumerate(figure.curves))) if curve.entry(language)}
    if len(told) <= MOST_NAMES:
        first = sorted(told.values())
        words = [figure.curves[k].entry(language) for k in first]
        places = along([np.array(drawn[k], dtype=float).reshape(-1, 2) for k in first], words, axes.frame, taken)
        names += "".join(_name(at, name, figure.curves[k].role) for k, name, at in zip(first, words, places, strict=True) if at)
        return "".join(out) + names, axes.height
    below, more = key([(c.entry(language), COLOURS["muted" if c.pin.id else c.role], c.dash) for c in figure.curves], W, axes.height)
    return "".join(out) + names + below, axes.height + more


def _names(marks: list[tuple[float, float, str]], drawn: np.ndarray, frame: Box) -> tuple[str, list[Box]]:
    """The names of marks, each beside its own and clear of the others, and what marks and names cover."""
    taken = [Box(x - 6, y - 6, x + 6, y + 6) for x, y, _ in marks]
    out = []
    for x, y, words in marks:
        if words:
            at = beside(x, y, words, frame, taken, drawn)
            taken.append(at.box)
            out.append(_name(at, words, ""))
    return "".join(out), taken


def _name(at: Name, words: str, role: str) -> str:
    """Words with a white rim, in the colour of a curve, darkened, if they are its name."""
    colour = f' fill="{_dark(COLOURS[role])}" font-weight="600"' if role else ""
    return (f'<text x="{at.x:.1f}" y="{at.y:.1f}" text-anchor="{at.anchor}" paint-order="stroke" stroke="#fff" '
            f'stroke-width="3"{colour}>{html.escape(words)}</text>')


def _dark(colour: str) -> str:
    """A colour #rrggbb nearer to black, to read words in."""
    return "#" + "".join(f"{round(INK * int(colour[i:i + 2], 16)):02x}" for i in (1, 3, 5))


def _mark(x: float, y: float, colour: str, mark: str) -> str:
    if not (math.isfinite(x) and math.isfinite(y)):
        return ""
    return {
        "cross": f'<path d="M{x - 5:.1f} {y - 5:.1f}l10 10m-10 0l10 -10" stroke="{colour}" stroke-width="2.6"/>',
        "circle": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="none" stroke="{colour}" stroke-width="2.2"/>',
        "hollow": f'<path d="M{x - 5:.1f} {y:.1f}l5 -5l5 5l-5 5z" fill="none" stroke="{colour}" stroke-width="1.4"/>',
        "dot": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>',
        "bolt": f'<path d="M{x - 6:.1f} {y:.1f}l3 -5.2h6l3 5.2l-3 5.2h-6z" fill="#282c34"/>',
    }[mark]


def _matrix(figure: MatrixFigure, language: str) -> tuple[str, float]:
    """Cells shaded by the logarithm of their magnitude, with the entries where they fit; exact zeros stay white."""
    m = np.asarray(figure.matrix, dtype=float)
    rows, cols = m.shape
    names = [symbol(wording(row, language)) for row in figure.rows]
    left = min(90.0, max(44.0, max((width(name, 9.0) for name in names), default=0.0) + 8))
    wide = (W - left - 8) / cols
    high = min(wide, TALLEST_CELL)
    heads, top = _heads([symbol(wording(name, language)) for name in figure.columns], left, wide)
    top_value = float(np.max(np.abs(m))) or 1.0
    out = []
    for i in range(rows):
        for j in range(cols):
            share = abs(m[i, j]) / top_value
            depth = 0.0 if share < 1e-9 else 0.15 + 0.85 * max(0.0, 1 + math.log10(share) / 6)
            x, y = left + j * wide, top + i * high
            out.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="{wide:.1f}" height="{high:.1f}" fill="{_blend(depth)}" '
                       f'stroke="#e8ebf0"><title>{m[i, j]:.4g}</title></rect>')
            if wide >= ROOM_FOR_ENTRY:
                entry = with_minus(f"{m[i, j] if depth else 0.0:.3g}")
                ink = "#fff" if depth > 0.6 else "#1c2430" if depth else "#5a616c"
                out.append(f'<text x="{x + wide / 2:.1f}" y="{y + high / 2 + 4:.1f}" text-anchor="middle" '
                           f'{_sized(entry, wide - 4)} fill="{ink}">{entry}</text>')
    for i, name in enumerate(names):
        size = min(_fitting(name, left - 6), high * 0.7)
        out.append(f'<text x="{left - 4}" y="{top + (i + 0.5) * high + 0.35 * size:.1f}" text-anchor="end" '
                   f'{_sized(name, left - 6, high * 0.7)}>{html.escape(name)}</text>')
    for b in figure.blocks:
        x, y = left + b * wide, top + b * high
        out.append(f'<path d="M{x:.1f} {top:.1f}V{top + rows * high:.1f}M{left} {y:.1f}H{left + cols * wide:.1f}" '
                   'stroke="#000" stroke-width="2"/>')
    return heads + "".join(out), top + rows * high + 8


def _heads(names: list[str], left: float, wide: float) -> tuple[str, float]:
    """The names over the columns of a matrix, upright where they would not fit across, and where the cells begin."""
    if not names:
        return "", 30.0
    if min(_fitting(name, wide - 2) for name in names) >= SMALLEST:
        return "".join(f'<text x="{left + (j + 0.5) * wide:.1f}" y="38" text-anchor="middle" '
                       f'{_sized(name, wide - 2)}>{html.escape(name)}</text>' for j, name in enumerate(names)), 44.0
    deep = 30 + max(width(name, 9.0) for name in names)
    return "".join(f'<text transform="translate({left + (j + 0.5) * wide + 3:.1f} {deep:.1f}) rotate(-90)" font-size="9">'
                   f"{html.escape(name)}</text>" for j, name in enumerate(names)), deep + 5


def _fitting(words: str, room: float, most: float = SIZE) -> float:
    """The font size at which words take at most this room."""
    return min(most, most * room / max(width(words, most), 1.0))


def _sized(words: str, room: float, tallest: float = math.inf) -> str:
    """Attributes of words that are to take at most this room: their size, and that in large print."""
    usual, large = (min(_fitting(words, room, most), tallest) for most in (SIZE, LARGE))
    return f'font-size="{usual:.1f}" style="--large:{large:.1f}px"'


def _blend(depth: float) -> str:
    """White to the plant's blue."""
    r, g, b = (round(255 + (c - 255) * depth) for c in (0, 114, 178))
    return f"#{r:02x}{g:02x}{b:02x}"


def _map(figure: MapFigure, language: str) -> tuple[str, float]:
    axes = _Axes(_span(figure.x), _span(figure.y), False, (wording(figure.x_label, language), wording(figure.y_label, language)))
    out = []
    dx, dy = (_step(v) for v in (figure.x, figure.y))
    for k, (_, role) in enumerate(figure.categories):
        path = []
        for i, j in np.argwhere(figure.values == k):
            x0, y0 = axes.at(float(figure.x[j]) - dx / 2, float(figure.y[i]) + dy / 2)
            x1, y1 = axes.at(float(figure.x[j]) + dx / 2, float(figure.y[i]) - dy / 2)
            path.append(f"M{x0:.1f} {y0:.1f}H{x1:.1f}V{y1:.1f}H{x0:.1f}z")
        out.append(f'<path d="{"".join(path)}" fill="{COLOURS[role]}" fill-opacity="0.75"/>')
    out.append(axes.draw())
    if figure.marked is not None:
        out.append(_mark(*axes.held(*figure.marked), COLOURS["reference"], "circle"))
    words, more = key([(name(language), COLOURS[role], "solid") for name, role in figure.categories], W, axes.height, patches=True)
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
        tied = ' class="ol-tied"' if width(words, 1.0) <= TIED else ""
        return f"<{kind}{tied}>{html.escape(words).replace(BETWEEN, BETWEEN[:-1] + '<wbr>' + BETWEEN[-1])}</{kind}>"
    head = "".join(cell(c, "th") for c in figure.columns)
    body = "".join("<tr>" + "".join(cell(v, "td") for v in row) + "</tr>" for row in figure.rows)
    return (f'<div class="ol-figure" data-figure="{figure.id}"><table class="ol-table"><caption>'
            f"{html.escape(figure.title(language))}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>")
