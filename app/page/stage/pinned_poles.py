"""Draw on a board the poles of pinned designs as hollow marks and those of a class as rings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any

import numpy as np
import viser

from ...classroom.answer_grids import with_conjugate
from ...course.lesson import Board

FIRST_MARK_HALF_HEIGHT, MARK_GROWTH = (
    0.07,
    0.018,
)  # half the height of the first pin's marks, in stage units, and how much each next one's is larger
THICK = 0.018
RING, LARGEST_RING = 0.04, 0.13  # radii of the ring around one placed pole, and of that where most were placed
CORNERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 0.0))
CIRCLE = tuple((math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)) for k in range(17))
Mark = tuple[complex, float]  # a pole and the size around it


class PinMarks:
    """One node of lines a pin, and one for all poles that a class has placed."""

    def __init__(self, scene: viser.SceneApi, root: str, colour: Any, place: Callable[[complex], tuple[float, float, float]]) -> None:
        self._scene, self._root, self._colour, self._place = scene, root, colour, place
        self._shown: tuple[Any, ...] = ((), ())
        self.nodes: list[Any] = []

    def show(self, board: Board) -> None:
        """The marks that a board has now."""
        if (board.pinned, board.placed) == self._shown:
            return
        for node in self.nodes:
            node.remove()
        self._shown = board.pinned, board.placed
        marks = {f"pin{place}": self._lines([(pole, FIRST_MARK_HALF_HEIGHT + place * MARK_GROWTH) for pole in poles], CORNERS)
                 for place, poles in board.pinned if poles}
        if board.placed:
            marks["placed"] = self._lines(_rings(board.placed), CIRCLE)
        self.nodes = [self._scene.add_line_segments(f"{self._root}/{name}", lines, self._colour, thickness=THICK)
                      for name, lines in marks.items()]

    def _lines(self, marks: Iterable[Mark], outline: tuple[tuple[float, float], ...]) -> np.ndarray:
        lines = []
        for pole, size in marks:
            x, y, z = self._place(pole)
            lines += list(pairwise([(x + size * a, y, z + size * b) for a, b in outline]))
        return np.array(lines, dtype=np.float32)


def _rings(placed: tuple[tuple[complex, int], ...]) -> list[Mark]:
    """Both poles of each pair; the area grows with how often it was placed."""
    most = max(count for _, count in placed)
    return [(each, RING + (LARGEST_RING - RING) * math.sqrt((count - 1) / max(most - 1, 1)))
            for pole, count in placed for each in with_conjugate(pole)]
