"""Draw the axes of a plane: area, grid, round numbers without overlap, and names."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from itertools import pairwise

from ...colours import COLOURS
from ...course.figures.ranges import decades
from .text_layout import LARGE_PRINT_PX, Box, fold_lines, text_width

W, H = 360, 254
LEFT_PX, RIGHT_PX, TOP_PX, BOTTOM_PX = 56, 12, 28, 40
MARK_CLEAR_PX, MARK_ROOM_PX = 7.0, 8.0  # from the middle of a mark to the frame: where one beyond it is held; at least
PLOT_FRAME = Box(LEFT_PX, TOP_PX, W - RIGHT_PX, H - BOTTOM_PX)
# of the names of axes: the height of a line in the tallest fonts, what of it rises above the foot of letters, px to the numbers
ROW_HEIGHT_PX, NAME_RISE_PX, NAME_CLEARANCE_PX = 1.45 * LARGE_PRINT_PX, 1.16 * LARGE_PRINT_PX, 8.0
NAME_DEPTH_PX = 6.0  # from the foot of the letters of the last row to the end of the drawing
NUMBER_FRAME_GAP_PX, NUMBER_FOOT_GAP_PX = (
    5.0,
    17.0,
)  # px from the numbers to the frame, and to the foot of those below it, clear of a number at the corner
NUMBER_GAP_PX, EDGE_GAP_PX = (
    6.0,
    5.0,
)  # px between two numbers below the frame, and from the last one to the edge, where a column may be slid


def clear_of_marks(span: tuple[float, float], marks: Sequence[float], long: float) -> tuple[float, float]:
    """A range that is widened where a mark in it would touch the frame of a drawing so many px long."""
    low, high = span
    room = MARK_ROOM_PX / (long - LEFT_PX - BOTTOM_PX) * (high - low)
    inside = [mark for mark in marks if low <= mark <= high]
    return min([low, *(mark - room for mark in inside)]), max([high, *(mark + room for mark in inside)])


class Axes:
    """Maps a range of the plane to the drawing area and draws grid, numbers and names.

    All names and numbers have the room that large print asks for: a name stands beside the numbers, and in lines where one
    would not hold it; of numbers there are as many as stand apart. `high` is the drawing's height before names below need more.
    """

    def __init__(self, x: tuple[float, float], y: tuple[float, float], equal: bool, names: tuple[str, str], powers: str = "",
                 high: float = H, places: tuple[tuple[float, str], ...] = ()) -> None:
        self.high, self._foot, self._powers = high, high - BOTTOM_PX, powers
        self._upright = fold_lines(names[1], (self._foot - TOP_PX) / LARGE_PRINT_PX).split("\n")
        self.left = PLOT_FRAME.left
        self._fit(x, y, equal)
        widest = max((text_width(name, LARGE_PRINT_PX) for _, name in self._levels()), default=0.0)
        self.left = max(self.left, len(self._upright) * ROW_HEIGHT_PX + NAME_CLEARANCE_PX + widest + NUMBER_FRAME_GAP_PX)
        self._fit(x, y, equal)
        self._across = fold_lines(names[0], (W - RIGHT_PX - self.left) / LARGE_PRINT_PX).split("\n")
        steps = [self.at(after, 0)[0] - self.at(before, 0)[0] for (before, _), (after, _) in pairwise(places)]
        room = (min(steps, default=W) - NUMBER_GAP_PX) / LARGE_PRINT_PX
        self._places = tuple((v, fold_lines(name, room)) for v, name in places)
        self._rows = max((name.count("\n") for _, name in self._places), default=0)  # of names below, beyond the first
        rows = self._rows + len(self._across) - 1
        free = 0.0 if any(self._across) else BOTTOM_PX - NUMBER_FOOT_GAP_PX - NAME_DEPTH_PX  # below the first row
        self.height = high + max(ROW_HEIGHT_PX * rows - free, 0.0)

    def _fit(self, x: tuple[float, float], y: tuple[float, float], equal: bool) -> None:
        across, up = W - self.left - RIGHT_PX, self._foot - TOP_PX
        if equal:
            scale = max((x[1] - x[0]) / across, (y[1] - y[0]) / up)
            cx, cy = sum(x) / 2, sum(y) / 2
            x = (cx - scale * across / 2, cx + scale * across / 2)
            y = (cy - scale * up / 2, cy + scale * up / 2)
        self.x, self.y = x, y
        self._sx, self._sy = across / (x[1] - x[0]), up / (y[1] - y[0])

    def _levels(self) -> list[tuple[float, str]]:
        """The numbers beside the frame, by their values."""
        most = round(5 * (self._foot - TOP_PX) / (PLOT_FRAME.bottom - PLOT_FRAME.top))
        found = _numbers(*self.y, most, "y" in self._powers)
        return [found[k] for k in apart([(self.at(0, v)[1], LARGE_PRINT_PX) for v, _ in found], 1.0)]

    def _below(self) -> list[tuple[float, float, str]]:
        """The numbers below the frame, or the names of places: where on the axis, and the middle of the words, inside the drawing."""
        if self._places:
            return [(px, px, name) for v, name in self._places for px in [self.at(v, 0)[0]]]
        for most in (6, 5, 4, 3, 2):
            found = []
            for v, name in _numbers(*self.x, most, "x" in self._powers):
                px, half = self.at(v, 0)[0], text_width(name, LARGE_PRINT_PX) / 2
                found.append((px, min(px, W - EDGE_GAP_PX - half), name))
            kept = apart([(x, text_width(name, LARGE_PRINT_PX)) for _, x, name in found], NUMBER_GAP_PX)
            if len(kept) == len(found):
                return found
        return [found[k] for k in kept]

    @property
    def frame(self) -> Box:
        """The drawing area."""
        return Box(self.left, TOP_PX, W - RIGHT_PX, self._foot)

    def at(self, x: float, y: float) -> tuple[float, float]:
        """The pixel of a point."""
        return self.left + (x - self.x[0]) * self._sx, self._foot - (y - self.y[0]) * self._sy

    def held(self, x: float, y: float) -> tuple[float, float]:
        """The pixel of a mark, or the nearest one that is clear of the frame."""
        (px, py), room = self.at(x, y), MARK_CLEAR_PX
        return min(max(px, self.left + room), W - RIGHT_PX - room), min(max(py, TOP_PX + room), self._foot - room)

    def area(self, left: float = 0.0) -> str:
        """Where the drawing area is, from a pixel on, as an element says it."""
        begin = max(left, self.left)
        return f'x="{begin:.1f}" y="{TOP_PX}" width="{W - RIGHT_PX - begin:.1f}" height="{self._foot - TOP_PX:.1f}"'

    def draw(self) -> str:
        """The frame, its grid, numbers and names."""
        foot = f"{self._foot:.1f}"
        out = [f'<rect {self.area()} fill="none" stroke="{COLOURS["chart-frame"]}"/>']
        for px, x, name in self._below():
            out.append(f'<line x1="{px:.1f}" x2="{px:.1f}" y1="{TOP_PX}" y2="{foot}" stroke="{COLOURS["chart-grid"]}"/>')
            for k, line in enumerate(name.split("\n")):
                y = self._foot + NUMBER_FOOT_GAP_PX + k * ROW_HEIGHT_PX
                out.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="middle">{html.escape(line)}</text>')
        for v, name in self._levels():
            _, py = self.at(0, v)
            out.append(
                f'<line x1="{self.left:.1f}" x2="{W - RIGHT_PX}" y1="{py:.1f}" y2="{py:.1f}" stroke="{COLOURS["chart-grid"]}"/>'
                f'<text x="{self.left - NUMBER_FRAME_GAP_PX:.1f}" y="{min(py + 4, self._foot - 1):.1f}" text-anchor="end">{name}</text>'
            )
        middle = (self.left + W - RIGHT_PX) / 2
        below = self.high - NAME_DEPTH_PX + self._rows * ROW_HEIGHT_PX
        out += [f'<text x="{middle:.1f}" y="{below + k * ROW_HEIGHT_PX:.1f}" text-anchor="middle">{html.escape(line)}</text>'
                for k, line in enumerate(self._across) if line]
        out += [
            f'<text transform="translate({NAME_RISE_PX + k * ROW_HEIGHT_PX:.1f} {(TOP_PX + self._foot) / 2:.1f}) rotate(-90)" '
            f'text-anchor="middle">'
            f"{html.escape(line)}</text>"
            for k, line in enumerate(self._upright)
        ]
        return "".join(out)


def apart(spots: Sequence[tuple[float, float]], gap: float) -> list[int]:
    """Which of some words in a row, each a middle and a length, can stand there with a gap between any two, the first kept first."""
    kept: list[int] = []
    for k, (middle, long) in enumerate(spots):
        if not kept or abs(middle - spots[kept[-1]][0]) >= (long + spots[kept[-1]][1]) / 2 + gap:
            kept.append(k)
    return kept


def _numbers(low: float, high: float, most: int, powers: bool) -> list[tuple[float, str]]:
    """Places and names of the numbers of an axis; over one of exponents the powers of ten."""
    if powers:
        return [(math.log10(value), name) for value, name in zip(*decades(10.0**low, 10.0**high, most), strict=True)]
    return [(v, f"{v:.6g}".replace("-", "−")) for v in ticks(low, high, most)]


def ticks(low: float, high: float, count: int = 6) -> list[float]:
    """Round numbers within [low, high], about `count` of them."""
    raw = (high - low) / count
    if not raw > 0 or not math.isfinite(raw):
        return [low]
    decade = 10.0 ** math.floor(math.log10(raw))
    step = next(s * decade for s in (1, 2, 5, 10) if s * decade >= raw * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [round(i * step, 12 - math.floor(math.log10(raw))) + 0.0 for i in range(first, last + 1)]
