"""Words in a drawing: how wide they are, where a name stands clear of what is drawn, and a key below the axes."""

from __future__ import annotations

import html
import unicodedata
from collections.abc import Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

DASHES = MappingProxyType({"solid": "", "dash": ' stroke-dasharray="7 4"', "dot": ' stroke-dasharray="2 3"'})
SIZE, LARGE = 11.0, 14.6  # px of the words in a drawing, and in one of large print
KEY_ROW = 16.0
SAMPLE, GAP = 20.0, 14.0  # of an entry of the key: the length of its line, the room after its name


def width(words: str, size: float = SIZE) -> float:
    """About how many pixels words take: a Chinese character is as wide as it is high, a Latin one little more than half."""
    return size * sum(1.0 if unicodedata.east_asian_width(c) in "WF" else 0.0 if unicodedata.combining(c) else 0.56 for c in words)


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


def beside(x: float, y: float, words: str, frame: Box, taken: Sequence[Box], drawn: np.ndarray) -> Name:
    """The best place for the name of a mark at (x, y): inside the frame, off other names and marks, on few points of curves."""
    wide = width(words)

    def place(dx: float, dy: float, anchor: str) -> Name:
        left = x + dx - {"start": 0.0, "middle": wide / 2, "end": wide}[anchor]
        return Name(x + dx, y + dy, anchor, Box(left, y + dy - 9, left + wide, y + dy + 2))

    def trouble(name: Name) -> float:
        box = name.box
        out = box.left < frame.left or box.right > frame.right or box.top < frame.top or box.bottom > frame.bottom
        return 1000.0 * out + 100.0 * sum(box.meets(other) for other in taken) + min(box.holds(drawn), 60)
    return min((place(8, -6, "start"), place(-8, -6, "end"), place(8, 14, "start"), place(-8, 14, "end"),
                place(0, -12, "middle"), place(0, 20, "middle")), key=trouble)


def key(entries: Sequence[tuple[str, str, str]], across: float, top: float, patches: bool = False) -> tuple[str, float]:
    """A key of (name, colour, dash) in centred rows from `top` down, each name once, and its height.

    `patches` draws squares of colour, for areas; lines otherwise.
    """
    told = list(dict.fromkeys(entry for entry in entries if entry[0]))
    rows: list[list[tuple[str, str, str]]] = [[]]
    used = 0.0
    for entry in told:
        needs = SAMPLE + 5 + width(entry[0]) + GAP
        if rows[-1] and used + needs > across:
            rows.append([])
            used = 0.0
        rows[-1].append(entry)
        used += needs
    out = []
    for i, row in enumerate(rows if told else []):
        signs, letters = len(row) * (SAMPLE + 5 + GAP) - GAP, sum(width(name) for name, _, _ in row)
        large = min(LARGE / SIZE, max(1.0, (across - signs) / max(letters, 1.0)))  # room is kept for large print
        x = (across - signs - large * letters) / 2
        y = top + KEY_ROW * (i + 0.5)
        for name, colour, dash in row:
            out.append(f'<rect x="{x + 5:.1f}" y="{y - 5:.1f}" width="10" height="10" fill="{colour}" fill-opacity="0.75"/>' if patches
                       else f'<line x1="{x:.1f}" x2="{x + SAMPLE:.1f}" y1="{y:.1f}" y2="{y:.1f}" stroke="{colour}" '
                            f'stroke-width="2.4"{DASHES[dash]}/>')
            out.append(f'<text x="{x + SAMPLE + 5:.1f}" y="{y + 4:.1f}" style="--large:{large * SIZE:.1f}px">{html.escape(name)}</text>')
            x += SAMPLE + 5 + large * width(name) + GAP
    return "".join(out), KEY_ROW * len(rows) + 4 if told else 0.0
