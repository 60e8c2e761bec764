"""Place the names on a pole board so that none covers a mark or another name."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...course.lesson import Board
from ..charts.text_layout import text_width

MARK_HALF_SIZE = 0.11  # half of a mark, in stage units
MARK_NAME_GAP = 0.04  # between a mark and its name
LINE_HEIGHT_EM = 1.25  # height of a line of letters in their size
PLACES_ACROSS, PLACES_UP = 49, 41  # places of a name that are tried where those beside its mark are taken
FAR, NEAR_ENOUGH = 9.0, 0.45  # half an axis; how far from its mark a name goes to be clear of lines
LEADER = 0.135  # a name farther than this from its mark is joined to it by a line


class Frame(NamedTuple):
    """The part of the board that names may fill."""

    left: float
    right: float
    bottom: float
    top: float


class Place(NamedTuple):
    """The middle of a name on a board, half its width and half its height, in stage units."""

    x: float
    z: float
    half: float
    tall: float

    def meets(self, other: Place) -> bool:
        """Whether two names share any area."""
        return abs(self.x - other.x) < self.half + other.half and abs(self.z - other.z) < self.tall + other.tall

    def covers(self, x: float, z: float) -> bool:
        """Whether a mark at (x, z) is touched."""
        return abs(self.x - x) < self.half + MARK_HALF_SIZE and abs(self.z - z) < self.tall + MARK_HALF_SIZE

    def nearest(self, x: float, z: float) -> tuple[float, float]:
        """The point of the name's box that is nearest to (x, z)."""
        return (min(max(x, self.x - self.half), self.x + self.half), min(max(z, self.z - self.tall), self.z + self.tall))


def free_place(x: float, z: float, words: str, em: float, frame: Frame, taken: Sequence[Place],
               marks: Sequence[tuple[float, float]]) -> Place | None:
    """Where the name of the mark at (x, z) is written in letters of size `em`: beside, above or below it, else the nearest
    place of the frame that is clear of all marks and names; None where there is none, since no name is better than one that
    covers something.
    """
    half, tall = (text_width(words, em) + 0.5 * em) / 2, LINE_HEIGHT_EM * em / 2
    room = Frame(frame.left + half, frame.right - half, frame.bottom + tall, frame.top - tall)
    if room.left > room.right or room.bottom > room.top:
        return None
    aside, above = MARK_HALF_SIZE + MARK_NAME_GAP + half, MARK_HALF_SIZE + MARK_NAME_GAP + tall
    for px, pz in ((x + aside, z), (x - aside, z), (x, z + above), (x, z - above)):
        at = Place(px, pz, half, tall)
        if (room.left <= px <= room.right and room.bottom <= pz <= room.top and not any(map(at.meets, taken))
                and not any(at.covers(*mark) for mark in marks)):
            return at
    return _anywhere(x, z, half, tall, room, taken, marks)


def best_place(x: float, z: float, words: str, em: float, frame: Frame, taken: Sequence[Place], marks: Sequence[tuple[float, float]],
               ways: Sequence[tuple[float, float]], axes: Sequence[tuple[float | None, float | None]]) -> Place | None:
    """The same, clear also of places on `ways` and of the `axes`, each at one x or at one z, where a name has room beside them."""
    lines = [Place(0.0 if at is None else at, 0.0 if up is None else up, FAR if at is None else 0.0, FAR if up is None else 0.0)
             for at, up in axes]
    for others, more in (((*taken, *lines), ways), (taken, ways)):
        at = free_place(x, z, words, em, frame, others, [*marks, *more])
        if at is not None and math.dist(at.nearest(x, z), (x, z)) <= NEAR_ENOUGH:
            return at
    return free_place(x, z, words, em, frame, taken, marks)


def _anywhere(x: float, z: float, half: float, tall: float, room: Frame, taken: Sequence[Place],
              marks: Sequence[tuple[float, float]]) -> Place | None:
    px, pz = np.meshgrid(np.linspace(room.left, room.right, PLACES_ACROSS), np.linspace(room.bottom, room.top, PLACES_UP))
    clear = np.ones_like(px, dtype=bool)
    for other in taken:
        clear &= (np.abs(px - other.x) >= half + other.half) | (np.abs(pz - other.z) >= tall + other.tall)
    for a, b in marks:
        clear &= (np.abs(px - a) >= half + MARK_HALF_SIZE) | (np.abs(pz - b) >= tall + MARK_HALF_SIZE)
    if not clear.any():
        return None
    far = np.hypot(np.maximum(np.abs(px - x) - half, 0.0), np.maximum(np.abs(pz - z) - tall, 0.0))
    best = int(np.argmin(np.where(clear, far, np.inf)))
    return Place(float(px.flat[best]), float(pz.flat[best]), half, tall)


def leader_line(at: Place, x: float, z: float,
                marks: Sequence[tuple[float, float]] = ()) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """The line that joins a name to its mark, None where it stands beside it, and beside no other of the marks that is nearer."""
    to = at.nearest(x, z)
    gap = math.dist(to, (x, z))
    nearer = any(math.dist(at.nearest(*mark), mark) < gap - 1e-9 for mark in marks)
    if gap <= MARK_HALF_SIZE + (MARK_NAME_GAP if nearer else LEADER):
        return None
    share = MARK_HALF_SIZE / gap
    return (x + share * (to[0] - x), z + share * (to[1] - z)), to


def pole_name(pole: complex, board: Board) -> str:
    """−4 ± 5j, or −2; with an arrow towards where it really lies if that is beyond the board's edge."""
    real = f"{pole.real:.3g}".replace("-", "−")
    name = real if pole.imag == 0 else f"{real} ± {abs(pole.imag):.3g}j"
    left, right, above = pole.real < board.re_low, pole.real > board.re_high, abs(pole.imag) > board.im_high
    return f"← {name}" if left else f"{name} →" if right else f"{name} ↑" if above else name
