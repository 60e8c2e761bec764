"""Lay a grid over a question's figure, so that equal drawings of a class count together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

COLUMNS, LEVELS = 11, 24  # of the grid: a whole drawing is one number below 2^53, which a store keeps exactly
LONGEST_SKETCH = 40  # heights that a browser may send
Place = tuple[int, int]  # a column and a level, both from 0


@dataclass(frozen=True)
class SketchGrid:
    """The frame of a question's figure in columns and LEVELS heights.

    Of a curve the pieces between neighbouring columns are counted, of bars their heights: a sum does not tell which pieces were one hand's.
    """

    columns: int
    bars: bool = False

    @property
    def pieces(self) -> int:
        """How many counts one drawing raises."""
        return self.columns if self.bars else self.columns - 1

    @property
    def cells(self) -> int:
        """How many counts there are."""
        return self.pieces * (LEVELS if self.bars else LEVELS**2)

    def number_of(self, heights: Sequence[float]) -> float | None:
        """A drawing as one whole number; None where its heights are not shares of the frame, or are too few or too many."""
        shares = np.asarray(heights, dtype=float)
        fits = len(shares) == self.columns if self.bars else self.columns <= len(shares) <= LONGEST_SKETCH
        if not fits or not bool(np.all((shares >= 0) & (shares <= 1))):
            return None
        at = np.linspace(0, len(shares) - 1, self.columns) if self.columns > 1 else np.zeros(1)
        levels = np.rint(np.interp(at, np.arange(len(shares)), shares) * (LEVELS - 1)).astype(int)
        return float(sum(int(level) * LEVELS**k for k, level in enumerate(levels)))

    def cells_of(self, number: float) -> tuple[int, ...]:
        """The counts that a drawing raises."""
        levels = [int(number) // LEVELS**k % LEVELS for k in range(self.columns)]
        if self.bars:
            return tuple(k * LEVELS + level for k, level in enumerate(levels))
        return tuple((k * LEVELS + one) * LEVELS + levels[k + 1] for k, one in enumerate(levels[:-1]))

    def places_of(self, cell: int) -> tuple[Place, ...]:
        """Where a count stands: one place of a bar, both ends of a piece of a curve."""
        if self.bars:
            return (divmod(cell, LEVELS),)
        before, after = divmod(cell, LEVELS)
        column, level = divmod(before, LEVELS)
        return (column, level), (column + 1, after)
