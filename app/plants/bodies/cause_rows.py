"""Lay a sloping panel before a body: each cause of an error as a bead, its part of the error as a bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import atan2, copysign, cos, hypot, sin

from ...colours import COLOURS
from ...text import Text
from .body import BENCH, DARK_GREY, PLANT_COLOUR, STEEL, Ball, Box, Part, Pose, Quaternion, Rod, Vector, pose_between

LEFT, RIGHT = -2.35, 2.35  # ends of the panel
NAMES, TRACK, TRACK_HALF = -1.72, -0.76, 0.36  # x of the names, middle and half of a bead's track
ZERO, HALF = 1.06, 1.08  # x of the value 0, and length of a bar of 1
EDGE_Y, PITCH, STEP, FOOT = -0.45, 0.165, 0.215, 0.07  # y of the upper edge; to the next row, and down to it; height of the lower edge
FIRST_ROW, AXIS_ROW, MARGIN = 0.6, 1.05, 0.45  # rows from the upper edge to the first row, from the last to the axis, from there to the end
THIN, THICK, BEAD = 0.06, 0.1, 0.095  # radius of a part's bar, of the sum's, of a bead
LEAST = 0.004  # the least share that is drawn
MARK, FLAT, SLAB, RIM = 0.03, 0.012, 0.07, 0.05  # across a line on the panel, its thickness; thickness of the panel, width of its rim
WORDS_UP, WORDS_OFF = 0.085, 0.06  # from the middle of a row to the upper edge of its name, and off the panel
SLOPE = atan2(STEP, PITCH)
TILTED: Quaternion = (cos(SLOPE / 2), sin(SLOPE / 2), 0.0, 0.0)


@dataclass(frozen=True)
class CauseRows:
    """A row for the start, one for each of `causes`, one for the sum; `marks` are the names of −1, 0 and 1, `axis` that of the bars."""

    start: Text
    causes: Sequence[Text]
    total: Text
    marks: tuple[str, str, str]
    axis: Text

    @property
    def count(self) -> int:
        """How many rows."""
        return len(self.causes) + 2

    @property
    def _end(self) -> float:
        return FIRST_ROW + self.count - 1 + AXIS_ROW + MARGIN

    @property
    def top(self) -> float:
        """How high the upper edge of the panel is."""
        return FOOT + STEP * self._end

    def _at(self, row: float, across: float, off: float = 0.0) -> Vector:
        """A point of the panel so many rows from the first one, or one `off` it toward the viewer."""
        down = FIRST_ROW + row
        return across, EDGE_Y - PITCH * down - off * sin(SLOPE), self.top - STEP * down + off * cos(SLOPE)

    def _long(self, rows: float) -> float:
        return rows * hypot(PITCH, STEP)

    def parts(self) -> tuple[Part, ...]:
        """The panel with lines at −1, 0 and 1 and above the sum, bars, tracks and beads of the causes."""
        last, long, rows = self.count - 1, self._long(self._end), self._long(self.count - 0.3)
        panel = (Part("panel", Box((RIGHT - LEFT, long, SLAB)), BENCH),
                 Part("panel face", Box((RIGHT - LEFT - 2 * RIM, long - 2 * RIM, FLAT)), COLOURS["paper"]),
                 *(Part(f"line {name}", Box((MARK if name == "0" else MARK / 2, rows, FLAT)), DARK_GREY if name == "0" else STEEL)
                   for name in ("-1", "0", "1")),
                 Part("line of the sum", Box((RIGHT - LEFT - 4 * RIM, MARK / 2, FLAT)), STEEL))
        bars = tuple(Part(f"part {k}", Rod(THICK if k == last else THIN), COLOURS["error"]) for k in range(self.count))
        beads = tuple(part for k in range(len(self.causes)) for part in (
            Part(f"track {k}", Box((2 * TRACK_HALF, 0.06, 0.03)), STEEL), Part(f"model {k}", Box((MARK, 0.2, 0.04)), DARK_GREY),
            Part(f"bead {k}", Ball(BEAD), PLANT_COLOUR)))
        return panel + bars + beads

    def fixed(self) -> dict[str, Pose]:
        """The poses of all parts that do not move."""
        middle, rows = self._end / 2 - FIRST_ROW, (self.count - 0.3) / 2 - 0.5
        found = {"panel": Pose(self._at(middle, 0.0, -SLAB / 2), TILTED), "panel face": Pose(self._at(middle, 0.0, FLAT / 4), TILTED),
                 "line of the sum": Pose(self._at(self.count - 1.52, 0.0, FLAT), TILTED)}
        found |= {f"line {name}": Pose(self._at(rows, ZERO + HALF * float(name), FLAT), TILTED) for name in ("-1", "0", "1")}
        for k in range(len(self.causes)):
            found |= {f"track {k}": Pose(self._at(k + 1, TRACK, 0.02), TILTED), f"model {k}": Pose(self._at(k + 1, TRACK, 0.03), TILTED)}
        return found

    def moving(self, shares: Sequence[float]) -> Mapping[str, Pose]:
        """Beads and bars. The shares, −1 to 1, are those of each cause, then of the start, of each part and of the sum."""
        causes, found = len(self.causes), {}
        for k in range(self.count):
            if 0 < k < self.count - 1:
                found[f"bead {k - 1}"] = Pose(self._at(k, TRACK + TRACK_HALF * _held(shares[k - 1]), BEAD))
            share, off = _drawn(shares[causes + k]), (THICK if k == self.count - 1 else THIN) + FLAT
            found[f"part {k}"] = pose_between(self._at(k, ZERO, off), self._at(k, ZERO + HALF * share, off))
        return found

    def labels(self) -> tuple[tuple[Text | str, Vector], ...]:
        """The names of the rows on the left, in the last row those of the axis and its marks."""
        def beside(row: float, across: float) -> Vector:
            _, y, z = self._at(row, across, WORDS_OFF)
            return across, y, z + WORDS_UP

        last = self.count - 1 + AXIS_ROW
        return (*((name, beside(k, NAMES)) for k, name in enumerate((self.start, *self.causes, self.total))),
                *((name, beside(last, ZERO + HALF * at)) for name, at in zip(self.marks, (-1, 0, 1), strict=True)),
                (self.axis, beside(last, NAMES)))


def _drawn(share: float) -> float:
    return copysign(max(abs(_held(share)), LEAST), share)


def _held(share: float) -> float:
    return min(max(float(share), -1.0), 1.0)
