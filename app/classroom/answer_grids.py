"""Lay grids over a pole board or a figure, so that equal answers of a class count together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

ACROSS, UP = 48, 24  # the most cells between the window's ends, and from the real axis to its top
DIGITS = 9  # significant ones of a place, so that three steps of 0.1 are 0.3
COLUMNS, LEVELS = 11, 24  # of the grid: a whole drawing is one number below 2^53, which a store keeps exactly
LONGEST_SKETCH = 40  # heights that a browser may send
Place = tuple[int, int]  # a column and a level, both from 0


def round_step(least: float) -> float:
    """The next of 1, 2, 5 times a power of ten."""
    decade = 10.0 ** math.floor(math.log10(least))
    return next(times * decade for times in (1, 2, 5, 10) if times * decade >= least * (1 - 1e-9))


def with_conjugate(pole: complex) -> tuple[complex, ...]:
    """Both poles of a pair, or the real one."""
    return (pole, pole.conjugate()) if pole.imag else (pole,)


@dataclass(frozen=True)
class PoleGrid:
    """The window of the board `board` in cells of one round width. A pole in the upper half stands for its pair."""

    board: str
    re_low: float
    re_high: float
    im_high: float
    disc: bool = False  # discrete time: stable is inside the unit circle

    @property
    def step(self) -> float:
        """The width and height of a cell."""
        return round_step(max((self.re_high - self.re_low) / ACROSS, self.im_high / UP))

    @property
    def _size(self) -> tuple[int, int, int]:
        """The number of the first column, counted from the imaginary axis, and how many columns and rows there are."""
        first, last = math.ceil(self.re_low / self.step - 1e-9), math.floor(self.re_high / self.step + 1e-9)
        return first, last - first + 1, math.floor(self.im_high / self.step + 1e-9) + 1

    @property
    def cells(self) -> int:
        """How many places there are for a pole."""
        _, columns, rows = self._size
        return columns * rows

    def cell_of(self, pole: complex) -> int | None:
        """The cell nearest to a pole; None outside the window, or where it is not finite."""
        first, columns, rows = self._size
        if not (math.isfinite(pole.real) and math.isfinite(pole.imag)):
            return None
        column, row = round(pole.real / self.step) - first, round(abs(pole.imag) / self.step)
        return row * columns + column if 0 <= column < columns and row < rows else None

    def pole_at(self, cell: int) -> complex:
        """The pole of a cell, in the upper half."""
        first, columns, _ = self._size
        row, column = divmod(cell, columns)
        return complex(*(float(f"{each * self.step:.{DIGITS}g}") for each in (first + column, row)))


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
