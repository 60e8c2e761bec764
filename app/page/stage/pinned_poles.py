"""Draw rings and hollow marks on a board: of pins, a class, a scene's start, the real loop."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any

import numpy as np
import viser

from ...classroom.answer_grids import with_conjugate
from ...course.lesson import Board
from ...text import NO_WORDS, Text, format_number
from ..charts.text_layout import text_width
from ..words import phrases
from .board_face import BoardColours
from .board_labels import LINE_HEIGHT_EM, Place
from .scene_labels import SceneLabels
from .viewpoint import BOARD_HEIGHT, BOARD_MARGIN, BOARD_WIDTH

FIRST_MARK_HALF_HEIGHT, MARK_GROWTH = (
    0.07,
    0.018,
)  # half the height of the first pin's marks, in stage units, and how much each next one's is larger
THICK = 0.018
LEFT, SMALLEST = -BOARD_WIDTH / 2 - 0.04, 0.85  # where the words on the rings begin; of the letters: their least size
ABOVE = 0.03  # stage units: the words on the rings stand over the lower edge of the board
RING, LARGEST_RING = 0.04, 0.13  # radii of the ring around one placed pole, and of that where most were placed
CORNERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 0.0))
CIRCLE = tuple((math.cos(k * math.pi / 16), math.sin(k * math.pi / 16)) for k in range(33))
Mark = tuple[complex, float]  # a pole and the size around it
BEGAN, LOOP = 0.115, 0.085  # radii of the rings where a pole began and where the loop has one
BOLD, WAY = 0.03, 0.016  # stage units: a ring of the loop, and the line from a pole to its ring
WAY_SPOTS = 5  # places on the line from a pole to its ring that names keep clear of
CROSS = 0.05  # stage units that a ring of the loop stands before the crosses
MOVED = 1e-9  # of a pole: one that is nearer has not moved


class PinMarks:
    """One node of lines a pin, one for all poles that a class has placed, and those of other places of the board's own poles."""

    def __init__(self, letters: SceneLabels, root: str, colour: Any, place: Callable[[complex], tuple[float, float, float]],
                 ink: BoardColours) -> None:
        self._letters, self._scene, self._root, self._colour, self._place, self._ink = letters, letters.scene, root, colour, place, ink
        self._shown: tuple[Any, ...] = ((), (), (), (), ())
        self._lines_shown: list[Any] = []
        self._said: viser.LabelHandle | None = None

    @property
    def nodes(self) -> list[Any]:
        """What of it is on the board."""
        return [*self._lines_shown, *([] if self._said is None else [self._said])]

    def show(self, board: Board, language: str) -> bool:
        """The marks that a board has now, and what its rings are; whether any came, went or moved."""
        shown = board.pinned, board.placed, board.began, board.loop, board.poles if board.began or board.loop else ()
        if shown == self._shown:
            return False
        for node in self._lines_shown:
            node.remove()
        if self._said is not None:
            self._letters.remove(self._said)
        self._shown = shown
        marks = {f"pin{place}": self._lines([(pole, FIRST_MARK_HALF_HEIGHT + place * MARK_GROWTH) for pole in poles], CORNERS)
                 for place, poles in board.pinned if poles}
        if board.placed:
            marks["placed"] = self._lines(_rings(board.placed), CIRCLE)
        self._lines_shown = [self._node(name, lines, self._colour, THICK) for name, lines in marks.items()]
        for name, others, radius, colour, thick, before in (("began", board.began, BEGAN, self._ink.leader, THICK, 0.0),
                                                            ("loop", board.loop, LOOP, self._ink.axis, BOLD, CROSS)):
            if others:
                self._lines_shown += [self._node(name, self._lines([(pole, radius) for pole in others], CIRCLE, before), colour, thick),
                                      self._node(f"{name} way", self._ways(board.poles, others, before), colour, WAY)]
        said = ring_words(board)(language)
        room = self._room(board)
        self._said = self._letters.write(
            f"{self._root}/rings", said, (LEFT, -0.06, self._foot_of_words(board, said)), "bottom-left",
            lambda em: _fitting(said, em, room)) if said else None
        return True

    def _size_of_words(self, board: Board, said: str) -> tuple[float, float]:
        """Half the width and half the height of the words on the rings."""
        size = _fitting(said, self._letters.em, self._room(board)) * self._letters.em
        return text_width(said, size) / 2 + 0.25 * size, LINE_HEIGHT_EM * size / 2

    def _foot_of_words(self, board: Board, said: str) -> float:
        """How high the words on the rings stand: at the foot of the board. Where rings or poles are there, below its real axis."""
        half, tall = self._size_of_words(board, said)
        marks = [self._place(pole) for pole in (*board.poles, *(board.loop or board.began))]
        foot = -BOARD_HEIGHT / 2 + ABOVE
        for low in (foot, self._place(0j)[2] - 2 * tall - ABOVE):
            if not any(x < LEFT + 2 * half + BEGAN and low - BEGAN < z < low + 2 * tall + BEGAN for x, _, z in marks):
                return low
        return foot

    def taken(self, board: Board, language: str) -> tuple[list[Place], list[tuple[float, float]]]:
        """What the words on the rings take of the board, and places on the lines from poles to their rings; nothing without rings."""
        said = ring_words(board)(language)
        if not said:
            return [], []
        half, tall = self._size_of_words(board, said)
        pairs = zip(board.poles, board.loop or board.began, strict=True)
        spots = [self._place(pole + k / WAY_SPOTS * (other - pole))
                 for pole, other in pairs if pole != other for k in range(1, WAY_SPOTS + 1)]
        return [Place(LEFT + half, self._foot_of_words(board, said) + tall, half, tall)], [(x, z) for x, _, z in spots]

    def _room(self, board: Board) -> float:
        """How wide the words on the rings may be: to the imaginary axis, or across the board where that is at its left."""
        axis = self._place(0j)[0] - LEFT
        return axis if not board.disc and axis > BOARD_WIDTH / 2 else BOARD_WIDTH + BOARD_MARGIN

    def _node(self, name: str, lines: np.ndarray, colour: Any, thick: float) -> Any:
        return self._scene.add_line_segments(f"{self._root}/{name}", lines, colour, thickness=thick)

    def _ways(self, poles: Iterable[complex], others: Iterable[complex], before: float) -> np.ndarray:
        """A line from each pole to its other place."""
        ways = np.array([(self._place(pole), self._place(other)) for pole, other in zip(poles, others, strict=True)], dtype=np.float32)
        return ways - np.array((0.0, before, 0.0), dtype=np.float32)

    def _lines(self, marks: Iterable[Mark], outline: tuple[tuple[float, float], ...], before: float = 0.0) -> np.ndarray:
        lines = []
        for pole, size in marks:
            x, y, z = self._place(pole)
            y -= before
            lines += list(pairwise([(x + size * a, y, z + size * b) for a, b in outline]))
        return np.array(lines, dtype=np.float32)


def ring_words(board: Board) -> Text:
    """What the rings of other places are, and how far the farthest is from its pole; no words where there are none."""
    others = board.loop or board.began
    if not others:
        return NO_WORDS
    far = max(abs(pole - other) for pole, other in zip(board.poles, others, strict=True))
    size = format_number(far, ".2g")
    if board.loop:
        return phrases.LOOP_RINGS.format(size=size)
    return phrases.NO_POLE_MOVED if far <= MOVED * max(map(abs, board.poles)) else phrases.POLES_MOVED.format(size=size)


def _fitting(said: str, em: float, room: float) -> float:
    """Of the letters' size: words that reach no farther than the room, if that leaves them large enough to read."""
    size = min(1.0, room / max(text_width(said, em), em))
    return size if size >= SMALLEST else min(1.0, (BOARD_WIDTH + BOARD_MARGIN) / max(text_width(said, em), em))


def _rings(placed: tuple[tuple[complex, int], ...]) -> list[Mark]:
    """Both poles of each pair; the area grows with how often it was placed."""
    most = max(count for _, count in placed)
    return [(each, RING + (LARGEST_RING - RING) * math.sqrt((count - 1) / max(most - 1, 1)))
            for pole, count in placed for each in with_conjugate(pole)]
