"""Divide the window of a pole board into cells, so that equal answers of a class count together."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .round_steps import round_step

ACROSS, UP = 48, 24  # the most cells between the window's ends, and from the real axis to its top
DIGITS = 9  # significant ones of a place, so that three steps of 0.1 are 0.3


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
