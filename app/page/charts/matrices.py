"""Draw a matrix as cells with entries and names, in the size of the print."""

from __future__ import annotations

import html
import math
from typing import NamedTuple

import numpy as np

from ...colours import COLOURS, rgb
from ...course.figures.records import MatrixFigure
from ...text import label_in_language, symbol
from ..words.prose import with_minus
from .axes import ROW_HEIGHT_PX, W
from .text_layout import LARGE_PRINT_PX, WORDS_PX, curve_key, fold_lines, text_width

TALLEST_CELL, ROOM_FOR_ENTRY, MIN_FONT_PX = 48, 38, 7.5  # of a matrix: height and width of cells, font size of names, in px
ROOM_FOR_SHORT_ENTRY = 24  # px of a cell of a category, whose entries are short
BLOCK_ROOM, LARGEST_BLOCK_NAME_PX = 0.8, 20.0  # of a block's width for its name; px of its letters
MOST_OF_NAMES = 0.4  # of a drawing's width in large print for the names of rows
LINE_HEIGHT_EM, NEXT_LINE_EM = 0.72, 1.1  # letters: a line of digits, from one line of an entry to the next


def matrix(figure: MatrixFigure, language: str, large: bool) -> tuple[str, float]:
    """Cells shaded by the logarithm of their magnitude, or in the colours of categories, with the entries where they fit."""
    m = np.asarray(figure.matrix, dtype=float)
    rows, cols = m.shape
    names = [symbol(label_in_language(row, language)) for row in figure.rows]
    left = _room_of_names(names, large)
    said = [fold_lines(name, (left - 10) / LARGE_PRINT_PX).split("\n") if large else [name] for name in names]
    wide = (W - left - 8) / cols
    high = max(min(wide, TALLEST_CELL), ROW_HEIGHT_PX * max((len(lines) for lines in said), default=1) - 2 if large else 0.0)
    heads, top = _heads([symbol(label_in_language(name, language)) for name in figure.columns], left, wide, large)
    depths, out, over = figure.fills, [], list(figure.block_names())
    fills = _blends(depths, figure.roles)
    least = 0.0 if over else ROOM_FOR_ENTRY if figure.kinds is None else ROOM_FOR_SHORT_ENTRY
    for i in range(rows):
        for j in range(cols):
            depth, x, y = depths[i, j], left + j * wide, top + i * high
            out.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="{wide:.1f}" height="{high:.1f}" fill="{fills[i][j]}" '
                       f'stroke="{COLOURS["chart-grid"]}"><title>{m[i, j]:.4g}</title></rect>')
            if wide >= least > 0:
                out.append(_entry(m[i, j] if depth or figure.kinds is not None else 0.0, _Cell(x, y, wide, high), large,
                                  COLOURS["paper" if depth > 0.6 else "ink" if depth else "dimmed"]))
    for i, lines in enumerate(said):
        size = min(
            min(_fitting(line, left - 6, LARGE_PRINT_PX if large else WORDS_PX) for line in lines), math.inf if large else high * 0.7
        )
        first = top + (i + 0.5) * high + 0.35 * size - ROW_HEIGHT_PX * (len(lines) - 1) / 2
        out += [
            f'<text x="{left - 4:.1f}" y="{first + k * ROW_HEIGHT_PX:.1f}" text-anchor="end" '
            f'font-size="{size:.1f}">{html.escape(line)}</text>'
            for k, line in enumerate(lines)
        ]
    for b in figure.blocks:
        x, y = left + b * wide, top + b * high
        out.append(f'<path d="M{x:.1f} {top:.1f}V{top + rows * high:.1f}M{left:.1f} {y:.1f}H{left + cols * wide:.1f}" '
                   f'stroke="{COLOURS["reference"]}" stroke-width="2"/>')
    for i in figure.lit:
        out.append(f'<rect x="{left:.1f}" y="{top + i * high:.1f}" width="{cols * wide:.1f}" height="{high:.1f}" fill="none" '
                   f'stroke="{COLOURS["reference"]}" stroke-width="2.6"/>')
    for row, column, name in over:
        words = symbol(label_in_language(name, language))
        size = _fitting(words, BLOCK_ROOM * wide * cols / (len(figure.blocks) + 1), LARGEST_BLOCK_NAME_PX)
        size = max(size, LARGE_PRINT_PX) if large else size
        out.append(f'<text x="{left + column * wide:.1f}" y="{top + row * high + 0.36 * size:.1f}" text-anchor="middle" '
                   f'font-size="{size:.1f}" font-weight="600" paint-order="stroke" stroke="{COLOURS["paper"]}" stroke-width="4">'
                   f'{html.escape(words)}</text>')
    foot = top + rows * high + 8
    told = [] if over else [(name(language), COLOURS[role], "solid") for name, role in figure.categories]
    key, more = curve_key(told, W, foot, patches=True, large=large)
    return heads + "".join(out) + key, foot + more


def _room_of_names(names: list[str], large: bool) -> float:
    """px for the names of rows; in large print no name is smaller than other words, a long one stands in lines."""
    if not large:
        return min(90.0, max(44.0, max((text_width(name, 9.0) for name in names), default=0.0) + 8))
    room = MOST_OF_NAMES * W / LARGE_PRINT_PX
    widest = max((text_width(line, LARGE_PRINT_PX) for name in names for line in fold_lines(name, room).split("\n")), default=0.0)
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
        size, lines = (
            LARGE_PRINT_PX,
            short(value, room / LARGE_PRINT_PX, 1 if cell.high < (LINE_HEIGHT_EM + NEXT_LINE_EM) * LARGE_PRINT_PX else 2),
        )
    else:
        whole = with_minus(f"{value:.3g}")
        size, lines = _fitting(whole, room), [whole]
    foot = cell.y + cell.high / 2 + 0.36 * size - NEXT_LINE_EM * size * (len(lines) - 1) / 2
    return "".join(
        f'<text x="{middle:.1f}" y="{foot + k * NEXT_LINE_EM * size:.1f}" text-anchor="middle" font-size="{size:.1f}" fill="{ink}">'
        f"{line}</text>"
        for k, line in enumerate(lines)
    )


def short(value: float, letters: float, most: int) -> list[str]:
    """A number in at most so many lines of so many letters, with as many of three digits as they hold; nothing where they hold none."""
    for digits in (3, 2, 1):
        plain = with_minus(f"{value:.{digits}g}")
        mantissa, power = f"{value:.{digits - 1}e}".split("e")
        scientific = with_minus(f"{mantissa}e{int(power)}")
        parts = scientific.replace("·10", "·\n10").split("\n")
        if text_width(plain, 1.0) <= letters:
            return [plain]
        if 1 < len(parts) <= most and all(text_width(part, 1.0) <= letters for part in parts):
            return parts
    return []


def _heads(names: list[str], left: float, wide: float, large: bool) -> tuple[str, float]:
    """The names over the columns of a matrix, upright where they would not fit across, and where the cells begin."""
    if not names:
        return "", 30.0
    most, least = (LARGE_PRINT_PX, LARGE_PRINT_PX) if large else (WORDS_PX, MIN_FONT_PX)
    sizes = [_fitting(name, wide - 2, most) for name in names]
    if min(sizes) >= least:
        return "".join(f'<text x="{left + (j + 0.5) * wide:.1f}" y="{42 if large else 38}" text-anchor="middle" '
                       f'font-size="{size:.1f}">{html.escape(name)}</text>'
                       for j, (name, size) in enumerate(zip(names, sizes, strict=True))), 50.0 if large else 44.0
    size = LARGE_PRINT_PX if large else 9.0
    every = math.ceil(ROW_HEIGHT_PX / wide) if large else 1  # names that would lie on each other are told for every other column
    deep = 30 + max(text_width(name, size) for name in names)
    return "".join(f'<text transform="translate({left + (j + 0.5) * wide + 0.35 * size:.1f} {deep:.1f}) rotate(-90)" '
                   f'font-size="{size:.1f}">{html.escape(name)}</text>' for j, name in enumerate(names) if j % every == 0), deep + 5


def _fitting(words: str, room: float, most: float = WORDS_PX) -> float:
    """The font size at which words take at most this room."""
    return min(most, most * room / max(text_width(words, most), 1.0))


def _blends(depths: np.ndarray, roles: np.ndarray | str = "plant") -> list[list[str]]:
    """White to the colour of each cell's role, by its depth."""
    full = np.array([rgb(COLOURS[role]) for role in np.broadcast_to(roles, depths.shape).ravel()]).reshape(*depths.shape, 3)
    colour = np.rint(255 + (full - 255) * depths[..., None]).astype(int)
    return [[f"#{number:06x}" for number in row] for row in (colour @ (65536, 256, 1)).tolist()]
