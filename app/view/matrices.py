"""A matrix as cells with their entries and names, in the size of the print."""

from __future__ import annotations

import html
import math
from typing import NamedTuple

import numpy as np

from ..lesson.figures import MatrixFigure
from ..text import symbol, wording
from .axes import ROW, W
from .lettering import LARGE, SIZE, folded, width
from .prose import with_minus

TALLEST_CELL, ROOM_FOR_ENTRY, SMALLEST = 48, 38, 7.5  # of a matrix: height and width of cells, font size of names, in px
MOST_OF_NAMES = 0.4  # of a drawing's width in large print for the names of rows
LINE, NEXT = 0.72, 1.1  # letters: a line of digits, from one line of an entry to the next


def matrix(figure: MatrixFigure, language: str, large: bool) -> tuple[str, float]:
    """Cells shaded by the logarithm of their magnitude, with the entries where they fit; exact zeros stay white."""
    m = np.asarray(figure.matrix, dtype=float)
    rows, cols = m.shape
    names = [symbol(wording(row, language)) for row in figure.rows]
    left = _room_of_names(names, large)
    said = [folded(name, (left - 10) / LARGE).split("\n") if large else [name] for name in names]
    wide = (W - left - 8) / cols
    high = max(min(wide, TALLEST_CELL), ROW * max((len(lines) for lines in said), default=1) - 2 if large else 0.0)
    heads, top = _heads([symbol(wording(name, language)) for name in figure.columns], left, wide, large)
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
                out.append(_entry(m[i, j] if depth else 0.0, _Cell(x, y, wide, high), large,
                                  "#fff" if depth > 0.6 else "#1c2430" if depth else "#5a616c"))
    for i, lines in enumerate(said):
        size = min(min(_fitting(line, left - 6, LARGE if large else SIZE) for line in lines), math.inf if large else high * 0.7)
        first = top + (i + 0.5) * high + 0.35 * size - ROW * (len(lines) - 1) / 2
        out += [f'<text x="{left - 4:.1f}" y="{first + k * ROW:.1f}" text-anchor="end" font-size="{size:.1f}">{html.escape(line)}</text>'
                for k, line in enumerate(lines)]
    for b in figure.blocks:
        x, y = left + b * wide, top + b * high
        out.append(f'<path d="M{x:.1f} {top:.1f}V{top + rows * high:.1f}M{left:.1f} {y:.1f}H{left + cols * wide:.1f}" '
                   'stroke="#000" stroke-width="2"/>')
    return heads + "".join(out), top + rows * high + 8


def _room_of_names(names: list[str], large: bool) -> float:
    """px for the names of rows; in large print no name is smaller than other words, a long one stands in lines."""
    if not large:
        return min(90.0, max(44.0, max((width(name, 9.0) for name in names), default=0.0) + 8))
    room = MOST_OF_NAMES * W / LARGE
    widest = max((width(line, LARGE) for name in names for line in folded(name, room).split("\n")), default=0.0)
    return max(24.0, widest + 10)


class _Cell(NamedTuple):
    x: float
    y: float
    wide: float
    high: float


def _entry(value: float, cell: _Cell, large: bool, ink: str) -> str:
    """The entry of a cell. In large print it keeps the size of other words: it has as many digits as there is room for, and its power
    of ten in a second line where one would not hold both."""
    room, middle = cell.wide - 4, cell.x + cell.wide / 2
    if large:
        size, lines = LARGE, short(value, room / LARGE, 1 if cell.high < (LINE + NEXT) * LARGE else 2)
    else:
        whole = with_minus(f"{value:.3g}")
        size, lines = _fitting(whole, room), [whole]
    foot = cell.y + cell.high / 2 + 0.36 * size - NEXT * size * (len(lines) - 1) / 2
    return "".join(f'<text x="{middle:.1f}" y="{foot + k * NEXT * size:.1f}" text-anchor="middle" font-size="{size:.1f}" fill="{ink}">'
                   f"{line}</text>" for k, line in enumerate(lines))


def short(value: float, letters: float, most: int) -> list[str]:
    """A number in at most so many lines of so many letters, with as many of three digits as they hold; nothing where they hold none."""
    for digits in (3, 2, 1):
        plain = with_minus(f"{value:.{digits}g}")
        mantissa, power = f"{value:.{digits - 1}e}".split("e")
        scientific = with_minus(f"{mantissa}e{int(power)}")
        parts = scientific.replace("·10", "·\n10").split("\n")
        if width(plain, 1.0) <= letters:
            return [plain]
        if 1 < len(parts) <= most and all(width(part, 1.0) <= letters for part in parts):
            return parts
    return []


def _heads(names: list[str], left: float, wide: float, large: bool) -> tuple[str, float]:
    """The names over the columns of a matrix, upright where they would not fit across, and where the cells begin."""
    if not names:
        return "", 30.0
    most, least = (LARGE, LARGE) if large else (SIZE, SMALLEST)
    sizes = [_fitting(name, wide - 2, most) for name in names]
    if min(sizes) >= least:
        return "".join(f'<text x="{left + (j + 0.5) * wide:.1f}" y="{42 if large else 38}" text-anchor="middle" '
                       f'font-size="{size:.1f}">{html.escape(name)}</text>'
                       for j, (name, size) in enumerate(zip(names, sizes, strict=True))), 50.0 if large else 44.0
    size = LARGE if large else 9.0
    every = math.ceil(ROW / wide) if large else 1  # names that would lie on each other are told for every other column
    deep = 30 + max(width(name, size) for name in names)
    return "".join(f'<text transform="translate({left + (j + 0.5) * wide + 0.35 * size:.1f} {deep:.1f}) rotate(-90)" '
                   f'font-size="{size:.1f}">{html.escape(name)}</text>' for j, name in enumerate(names) if j % every == 0), deep + 5


def _fitting(words: str, room: float, most: float = SIZE) -> float:
    """The font size at which words take at most this room."""
    return min(most, most * room / max(width(words, most), 1.0))


def _blend(depth: float) -> str:
    """White to the plant's blue."""
    r, g, b = (round(255 + (c - 255) * depth) for c in (0, 114, 178))
    return f"#{r:02x}{g:02x}{b:02x}"
