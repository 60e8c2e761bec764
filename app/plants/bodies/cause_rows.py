"""Lay rows before a body: each cause of an error as a bead, its part of the error as a bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import copysign

from ...colours import COLOURS
from ...text import Text
from .body import BENCH, DARK_GREY, PLANT_COLOUR, STEEL, Ball, Box, Part, Pose, Rod, Vector, pose_between

LEFT, RIGHT = -2.3, 2.3  # ends of the steps
NAMES, TRACK, TRACK_HALF = -1.72, -0.82, 0.36  # x of the names, middle and half of a bead's track
ZERO, HALF = 1.06, 1.08  # x of the value 0, and length of a bar of 1
FIRST_Y, PITCH, STEP, FLOOR = -0.54, 0.16, 0.23, 0.3  # y of the first row; to the next one, and down to it; height of the last
THIN, THICK, BEAD = 0.06, 0.1, 0.095  # radius of a part's bar, of the sum's, of a bead
LEAST = 0.004  # the least share that is drawn
MARK = 0.03


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
    def top(self) -> float:
        """How high the uppermost step is."""
        return FLOOR + STEP * (self.count - 1)

    def _rows(self) -> list[tuple[float, float]]:
        return [(FIRST_Y - PITCH * k, self.top - STEP * k) for k in range(self.count)]

    def parts(self) -> tuple[Part, ...]:
        """Steps, a zero plate and a bar on each, tracks and beads of the causes."""
        last = self.count - 1
        steps = tuple(part for k, (_, high) in enumerate(self._rows()) for part in (
            Part(f"step {k}", Box((RIGHT - LEFT, PITCH, high)), BENCH),
            *(Part(f"{side} {k}", Box((MARK, 0.8 * PITCH, 0.03)), DARK_GREY) for side in ("least", "most") if k == last),
            Part(f"none {k}", Box((MARK, 0.8 * PITCH, 0.22)), DARK_GREY),
            Part(f"part {k}", Rod(THICK if k == last else THIN), COLOURS["error"])))
        beads = tuple(part for k in range(len(self.causes)) for part in (
            Part(f"track {k}", Box((2 * TRACK_HALF, 0.08, 0.04)), STEEL), Part(f"model {k}", Box((MARK, 0.2, 0.1)), DARK_GREY),
            Part(f"bead {k}", Ball(BEAD), PLANT_COLOUR)))
        return steps + beads

    def fixed(self) -> dict[str, Pose]:
        """The poses of all parts that do not move."""
        found = {}
        for k, (y, high) in enumerate(self._rows()):
            found |= {f"step {k}": Pose(((LEFT + RIGHT) / 2, y, high / 2)), f"none {k}": Pose((ZERO, y, high + 0.11))}
            if k == self.count - 1:
                found |= {f"{side} {k}": Pose((ZERO + sign * HALF, y, high + 0.015)) for side, sign in (("least", -1), ("most", 1))}
            if 0 < k < self.count - 1:
                found |= {f"track {k - 1}": Pose((TRACK, y, high + 0.02)), f"model {k - 1}": Pose((TRACK, y, high + 0.05))}
        return found

    def moving(self, shares: Sequence[float]) -> Mapping[str, Pose]:
        """Beads and bars. The shares, −1 to 1, are those of each cause, then of the start, of each part and of the sum."""
        causes, found = len(self.causes), {}
        for k, (y, high) in enumerate(self._rows()):
            if 0 < k < self.count - 1:
                found[f"bead {k - 1}"] = Pose((TRACK + TRACK_HALF * _held(shares[k - 1]), y, high + BEAD))
            share, z = _drawn(shares[causes + k]), high + (THICK if k == self.count - 1 else THIN) + 0.01
            found[f"part {k}"] = pose_between((ZERO, y, z), (ZERO + HALF * share, y, z))
        return found

    def labels(self) -> tuple[tuple[Text | str, Vector], ...]:
        """The names of the rows on their steps, those of the marks and the axis on the face below."""
        front, low = FIRST_Y - PITCH * (self.count - 0.5) - 0.02, FLOOR - 0.02
        return (*((name, (NAMES, y - 0.06, high + 0.12)) for name, (y, high) in
                  zip((self.start, *self.causes, self.total), self._rows(), strict=True)),
                *((name, (ZERO + HALF * at, front, low)) for name, at in zip(self.marks, (-1, 0, 1), strict=True)),
                (self.axis, (ZERO, front, low - 0.16)))


def _drawn(share: float) -> float:
    return copysign(max(abs(_held(share)), LEAST), share)


def _held(share: float) -> float:
    return min(max(float(share), -1.0), 1.0)
