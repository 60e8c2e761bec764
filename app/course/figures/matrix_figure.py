"""Define a matrix as cells: shaded by their magnitudes, or in the colours of categories."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...text import NO_WORDS, Text, label_in_language, text
from .curves import finite
from .figure_record import Entry, FigureRecord, Part, Sheet, distinct, numbered

MATRICES = text("Matrices")  # the tab of matrices
ZERO_ENTRY_RTOL, SHADE_DECADES = 1e-9, 6.0  # share of the largest entry that is drawn as zero; decades from palest to darkest
PALE, FULL = 0.16, 0.6  # how deep the colour of a category is where its entry is zero, and elsewhere


@dataclass(frozen=True, eq=False)
class MatrixFigure(FigureRecord):
    """A heat map of the magnitudes of a matrix, with lines between its blocks; or its cells in the colours of categories.

    `kinds` (of the matrix's shape) gives each cell the number of its category of name and role, −1 to a cell without colour. Then a block
    that `blocks` cuts out carries the name of its category, and 0 where it has none.
    """

    id: str
    title: Text
    matrix: np.ndarray
    rows: tuple[Text | str, ...] = ()
    columns: tuple[Text | str, ...] = ()
    blocks: tuple[int, ...] = ()  # a line is drawn before each of these rows and columns
    caption: Text = NO_WORDS
    tab: Text = MATRICES
    categories: tuple[tuple[Text, str], ...] = ()
    kinds: np.ndarray | None = None
    lit: tuple[int, ...] = ()  # rows with a frame around them

    @property
    def kind(self) -> str:
        return "matrix"

    def axes(self, language: str = "en") -> tuple[str, str]:
        return "", ""

    def _names(self, language: str) -> tuple[list[str], list[str]]:
        """The names of rows and columns, their numbers where they have none."""
        rows, columns = ([label_in_language(name, language) for name in names] or [str(k) for k in range(count)]
                         for names, count in zip((self.rows, self.columns), self.matrix.shape, strict=True))
        return rows, columns

    def table(self, language: str = "en") -> Sheet:
        rows, columns = self._names(language)
        return ["", *distinct(columns)], [(name, *map(float, row)) for name, row in zip(rows, self.matrix, strict=True)]

    def entries(self) -> Iterator[Entry]:
        rows, columns = self._names("en")
        for (i, j), entry in np.ndenumerate(np.asarray(self.matrix, dtype=float)):
            yield f"{rows[i]}, {columns[j]}", float(j), float(i), float(entry)

    def parts(self) -> Iterator[Part]:
        yield from (*numbered("column", self.columns), *numbered("row", self.rows),
                    *numbered("category", (name for name, _ in self.categories)))

    @property
    def fills(self) -> np.ndarray:
        """The depth of each cell's colour, 0 to 1. In a category a zero is pale; else it goes by the decades of the magnitude."""
        sizes = np.abs(finite(self.matrix))
        share = sizes / (float(sizes.max(initial=0.0)) or 1.0)
        nothing = share < ZERO_ENTRY_RTOL
        if self.kinds is None:
            depth = 0.15 + 0.85 * np.maximum(0.0, 1 + np.log10(np.maximum(share, ZERO_ENTRY_RTOL)) / SHADE_DECADES)
            return np.where(nothing, 0.0, depth)
        return np.where(self.kinds < 0, 0.0, np.where(nothing, PALE, FULL))

    @property
    def roles(self) -> np.ndarray:
        """The role of each cell's colour."""
        if self.kinds is None:
            return np.full(self.matrix.shape, "plant")
        return np.array([*(role for _, role in self.categories), "plant"])[np.asarray(self.kinds)]

    def block_names(self) -> Iterator[tuple[float, float, Text | str]]:
        """The middle (row, column) of each block of a category and its name; all other blocks have none."""
        if self.kinds is None or not self.blocks:
            return
        cuts = [sorted({0, *(b for b in self.blocks if b < size), size}) for size in self.matrix.shape]
        for top, foot in pairwise(cuts[0]):
            for left, right in pairwise(cuts[1]):
                if len(here := np.unique(self.kinds[top:foot, left:right])) == 1:
                    yield (top + foot) / 2, (left + right) / 2, self.categories[int(here[0])][0] if here[0] >= 0 else "0"
