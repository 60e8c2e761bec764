"""Measure and place words in a drawing: widths, clear places for names, the key below the axes."""

from __future__ import annotations

import html
import math
import re
import unicodedata
from collections.abc import Sequence
from functools import lru_cache
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

SVG_DASHES = MappingProxyType({"solid": "", **{dash: f' stroke-dasharray="{pattern}"' for dash, pattern in (
    ("dash", "7 4"), ("dot", "2 3"), ("pin1", "3 3"), ("pin2", "12 3"), ("pin3", "9 3 2 3"), ("pin4", "6 2 2 2 2 2"))}})
WORDS_PX, LARGE_PRINT_PX = 12.0, 14.6  # px of the words in a drawing, and in one of large print
KEY_ROW, LARGE_ROW = 16.0, 19.0  # px from one row of a key to the next, and in large print
ANCHORS, CURVE_STEP_PX = 28, 6.0  # points of a curve that its name is tried at; px between the points that are looked at
SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻"
KEY_LINE_PX, KEY_GAP_PX = 20.0, 14.0  # of an entry of the key: the length of its line, the room after its name


def text_width(words: str, size: float = WORDS_PX) -> float:
    """About how many pixels words take: a Chinese character is as wide as it is high, a Latin one little more than half, a raised one
    a third."""
    return size * _letters(words)


@lru_cache(maxsize=4096)
def _letters(words: str) -> float:
    """The width in units of the height."""
    return sum([
        0.36 if c in SUPERSCRIPTS else 1.0 if unicodedata.east_asian_width(c) in "WF" else 0.0 if unicodedata.combining(c) else 0.56
        for c in words
    ])


def fold_lines(words: str, most: float) -> str:
    """Words in lines of about equal length of which none is wider than `most` letters, where they can be broken: at spaces, and
    between Chinese characters but not before a comma or a stop."""
    pieces = re.findall(r"[\u2e80-\uffee][，。：；、）”！？]*|[^\s\u2e80-\uffee]+\s*|\s+", words)
    count = max(1, math.ceil(text_width(words, 1.0) / max(most, 1.0)))
    lines = [""]
    for piece in pieces:
        longest = min(1.1 * text_width(words, 1.0) / count, most) if len(lines) < count else most
        if lines[-1] and text_width((lines[-1] + piece).rstrip(), 1.0) > longest:
            lines.append("")
        lines[-1] += piece
    return "\n".join(line.strip() for line in lines)


class Box(NamedTuple):
    """A rectangle in pixels, y downwards."""

    left: float
    top: float
    right: float
    bottom: float

    def meets(self, other: Box) -> bool:
        """Whether two boxes share any area."""
        return self.left < other.right and other.left < self.right and self.top < other.bottom and other.top < self.bottom

    def holds(self, points: np.ndarray) -> int:
        """How many of the points (n, 2) lie inside."""
        return int(np.count_nonzero((points[:, 0] > self.left) & (points[:, 0] < self.right)
                                    & (points[:, 1] > self.top) & (points[:, 1] < self.bottom)))


class Name(NamedTuple):
    """Where a name is written: the point that its anchor stands at, and the box that it fills."""

    x: float
    y: float
    anchor: str
    box: Box


def place_beside_mark(x: float, y: float, words: str, frame: Box, taken: Sequence[Box], drawn: np.ndarray) -> Name:
    """The best place for the name of a mark at (x, y): inside the frame, off other names and marks, on few points of curves; room
    is kept for large print."""
    wide = text_width(words, LARGE_PRINT_PX)

    def place(dx: float, dy: float, anchor: str) -> Name:
        left = x + dx - {"start": 0.0, "middle": wide / 2, "end": wide}[anchor]
        return Name(x + dx, y + dy, anchor, Box(left, y + dy - 0.85 * LARGE_PRINT_PX, left + wide, y + dy + 0.25 * LARGE_PRINT_PX))

    def trouble(name: Name) -> float:
        box = name.box
        out = box.left < frame.left or box.right > frame.right or box.top < frame.top or box.bottom > frame.bottom
        return 1000.0 * out + 100.0 * sum(box.meets(other) for other in taken) + min(box.holds(drawn), 60)
    return min((place(8, -6, "start"), place(-8, -6, "end"), place(8, 16, "start"), place(-8, 16, "end"),
                place(0, -12, "middle"), place(0, 22, "middle"), place(8, -30, "start"), place(-8, -30, "end"),
                place(8, 40, "start"), place(-8, 40, "end")), key=trouble)


def place_along_curves(curves: Sequence[np.ndarray], names: Sequence[str], frame: Box, taken: Sequence[Box]) -> list[Name | None]:
    """A place for the name of each curve, (n, 2) in pixels, beside a point of it: inside the frame, off other names and
    marks, where few curves pass and its own is the nearest. None where a curve does not show."""
    paths = [_even(curve, frame) for curve in curves]
    out: list[Name | None] = []
    for k, words in enumerate(names):
        boxes = _around(paths[k][:: max(1, len(paths[k]) // ANCHORS)], text_width(words, LARGE_PRINT_PX), frame)
        if not len(boxes):
            out.append(None)
            continue
        trouble = 60.0 * sum(_meets(boxes, other) for other in (*taken, *(name.box for name in out if name)))
        gaps = [_gap(boxes, path) for path in paths if len(path)]
        own = _gap(boxes, paths[k])
        trouble = trouble + 3.0 * (own <= 0).sum(axis=1)
        for path, gap in zip([p for p in paths if len(p)], gaps, strict=True):
            if path is not paths[k]:
                trouble = trouble + 6.0 * (gap <= 0).sum(axis=1) + 4.0 * (gap.min(axis=1) < 8)
        middle = (frame.left + 3 * frame.right) / 4
        trouble = trouble + 0.004 * np.abs(boxes[:, [0, 2]].mean(axis=1) - middle)
        left, top, _, bottom = boxes[int(np.argmin(trouble))]
        out.append(Name(left, bottom - 4, "start", Box(left, top, left + text_width(words, LARGE_PRINT_PX), bottom)))
    return out


def _even(curve: np.ndarray, frame: Box) -> np.ndarray:
    """Points of a curve every few pixels, as far as it lies inside the frame."""
    if len(curve) < 2:
        return np.empty((0, 2))
    run = np.concatenate([[0.0], np.cumsum(np.minimum(np.hypot(*np.diff(curve, axis=0).T), 1e5))])
    at = np.linspace(0.0, run[-1], int(min(max(run[-1] / CURVE_STEP_PX, 2), 400)))
    points = np.column_stack([np.interp(at, run, curve[:, i]) for i in (0, 1)])
    inside = (points >= (frame.left, frame.top)) & (points <= (frame.right, frame.bottom))
    return points[inside.all(axis=1)]


def _around(points: np.ndarray, wide: float, frame: Box) -> np.ndarray:
    """Boxes (k, 4) of a name above, below, right and left of points, those that lie inside the frame."""
    x, y = points.reshape(-1, 2).T
    tall, near = LARGE_PRINT_PX, 5.0
    lefts = np.concatenate([x - wide / 2, x - wide / 2, x + near + 3, x - near - 3 - wide])
    tops = np.concatenate([y - near - tall, y + near, y - tall / 2, y - tall / 2])
    boxes = np.column_stack([lefts, tops, lefts + wide, tops + tall])
    return boxes[(lefts > frame.left + 2) & (lefts + wide < frame.right - 2) & (tops > frame.top + 2) & (tops + tall < frame.bottom - 2)]


def _meets(boxes: np.ndarray, other: Box) -> np.ndarray:
    left, top, right, bottom = boxes.T
    return ((left < other.right) & (other.left < right) & (top < other.bottom) & (other.top < bottom)).astype(float)


def _gap(boxes: np.ndarray, path: np.ndarray) -> np.ndarray:
    """How far (k, n) points lie from boxes, 0 inside."""
    x, y = path[:, 0], path[:, 1]
    across = np.maximum(boxes[:, 0, None] - x, x - boxes[:, 2, None])
    down = np.maximum(boxes[:, 1, None] - y, y - boxes[:, 3, None])
    return np.maximum(np.maximum(across, down), 0.0)


def curve_key(entries: Sequence[tuple[str, str, str]], across: float, top: float, patches: bool = False,
              large: bool = False, solid: float = 1.0) -> tuple[str, float]:
    """A key of (name, colour, dash) in centred rows from `top` down, each name once, and its height; `patches` draws squares of
    colour as `solid` as the areas are, lines otherwise. One name too long for a row is smaller."""
    told = list(dict.fromkeys(entry for entry in entries if entry[0]))
    size, high = (LARGE_PRINT_PX, LARGE_ROW) if large else (WORDS_PX, KEY_ROW)
    rows: list[list[tuple[str, str, str]]] = [[]]
    used = 0.0
    for entry in told:
        needs = KEY_LINE_PX + 5 + text_width(entry[0], size) + KEY_GAP_PX
        if rows[-1] and used + needs - KEY_GAP_PX > across:
            rows.append([])
            used = 0.0
        rows[-1].append(entry)
        used += needs
    out = []
    for i, row in enumerate(rows if told else []):
        signs, letters = len(row) * (KEY_LINE_PX + 5 + KEY_GAP_PX) - KEY_GAP_PX, sum(text_width(name, size) for name, _, _ in row)
        less = min(1.0, (across - signs) / max(letters, 1.0))
        x = (across - signs - less * letters) / 2
        y = top + high * (i + 0.5)
        for name, colour, dash in row:
            out.append(f'<rect x="{x + 5:.1f}" y="{y - 5:.1f}" width="10" height="10" '
                       + (f'fill="{colour}" fill-opacity="{solid:g}"/>' if dash == "solid" else
                          f'fill="none" stroke="{colour}" stroke-width="1.6" stroke-dasharray="3 2"/>') if patches
                       else f'<line x1="{x:.1f}" x2="{x + KEY_LINE_PX:.1f}" y1="{y:.1f}" y2="{y:.1f}" stroke="{colour}" '
                            f'stroke-width="2.4"{SVG_DASHES[dash]}/>')
            out.append(
                f'<text x="{x + KEY_LINE_PX + 5:.1f}" y="{y + 0.36 * size:.1f}" font-size="{less * size:.1f}">{html.escape(name)}</text>'
            )
            x += KEY_LINE_PX + 5 + less * text_width(name, size) + KEY_GAP_PX
    return "".join(out), high * len(rows) + 4 if told else 0.0
