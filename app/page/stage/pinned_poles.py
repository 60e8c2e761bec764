"""Draw the poles of pinned designs on a board as hollow marks of growing size."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import viser

from ...course.lesson import Board

FIRST_MARK_HALF_HEIGHT, MARK_GROWTH = (
    0.07,
    0.018,
)  # half the height of the first pin's marks, in stage units, and how much each next one's is larger
THICK = 0.018
CORNERS = ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 0))


class PinMarks:
    """One node of lines a pin."""

    def __init__(self, scene: viser.SceneApi, root: str, colour: Any, place: Callable[[complex], tuple[float, float, float]]) -> None:
        self._scene, self._root, self._colour, self._place = scene, root, colour, place
        self._shown: tuple[Any, ...] = ()
        self.nodes: list[Any] = []

    def show(self, board: Board) -> None:
        """The marks of the pins that a board has now."""
        if board.pinned == self._shown:
            return
        for node in self.nodes:
            node.remove()
        self._shown = board.pinned
        self.nodes = [
            self._scene.add_line_segments(
                f"{self._root}/pin{place}", self._lines(poles, FIRST_MARK_HALF_HEIGHT + place * MARK_GROWTH), self._colour, thickness=THICK
            )
            for place, poles in board.pinned
            if poles
        ]

    def _lines(self, poles: tuple[complex, ...], size: float) -> np.ndarray:
        lines = []
        for pole in poles:
            x, y, z = self._place(pole)
            corners = [(x + size * a, y, z + size * b) for a, b in CORNERS]
            lines += list(pairwise(corners))
        return np.array(lines, dtype=np.float32)
