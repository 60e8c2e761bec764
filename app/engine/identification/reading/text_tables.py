"""Parse the chosen columns of a text table, and name the row of what is no number."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ...systems.errors import EngineError, Phrase, phrase
from .layout import Layout, cells_of, laid_out
from .numerals import Numerals, numerals_of
from .tables import Heading

__all__ = ["TextTable"]

SIMPLE = re.compile(r"[0-9eE+\-.,\r\n\t ]*")


class TextTable:
    """The columns of a text; a column that nobody asks for is not parsed. `decimal`: the sign a person says, "" to find it."""

    def __init__(self, text: str, decimal: str = "") -> None:
        self._layout: Layout = laid_out(text)
        self._decimal = decimal
        self._said: list[Phrase] = []

    @property
    def headings(self) -> tuple[Heading, ...]:
        """One heading for each column."""
        return self._layout.headings

    @property
    def lines(self) -> np.ndarray:
        """The number of each row in the file."""
        return np.array(self._layout.lines)

    @property
    def notes(self) -> tuple[Phrase, ...]:
        """What was done to the file."""
        return (*self._layout.notes, *self._said)

    @cached_property
    def _split(self) -> list[list[str]]:
        """The cells of all rows. Raises EngineError for a row with more or fewer of them than names."""
        out, width, mark = [], len(self.headings), self._layout.mark
        for line, words in zip(self._layout.lines, self._layout.rows, strict=True):
            cells = cells_of(words, mark)
            if len(cells) == width + 1 and not cells[-1]:
                cells.pop()
            if len(cells) != width:
                raise EngineError("In row {row} the number of values differs from that of the names in the first line: {count} instead of "
                                  "{columns}.", row=line, count=len(cells), columns=width)
            out.append(cells)
        return out

    def words(self, column: int) -> list[str]:
        """The cells of a column as they are written."""
        return [cells[column] for cells in self._split]

    def numbers(self, columns: Sequence[int]) -> np.ndarray:
        """Columns as numbers, NaN where missing: at once where the file is plain, cell by cell where it is not."""
        table = self._plain() if self._layout.mark == "," and self._decimal != "," else None
        if table is not None:
            return table[:, list(columns)]
        named = [(self.headings[k].words, self.words(k)) for k in columns]
        signs = numerals_of(named, self._layout.lines, self._decimal)
        if signs.group and any(signs.group in cell for _, cells in named for cell in cells):
            self._said.append(phrase("The sign {sign} was read as the one between thousands.", sign=signs.group))
        return np.column_stack([self._column(name, cells, signs) for name, cells in named])

    def _plain(self) -> np.ndarray | None:
        """All columns of a file of plain numbers, None for any other."""
        body = "\n".join(self._layout.rows)
        if SIMPLE.fullmatch(body) is None:
            return None
        try:
            table = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2)
        except ValueError:
            return None  # empty cells or something to name
        return table if table.shape[1] == len(self.headings) else None

    def _column(self, name: str, cells: Sequence[str], signs: Numerals) -> np.ndarray:
        out = np.empty(len(cells))
        for k, cell in enumerate(cells):
            value = signs.value(cell)
            if value is None:
                line = self._layout.lines[k]
                if cell in (name, self._bare(name)):
                    raise EngineError("The head line stands again in row {row}; cut the file there and read one part.", row=line)
                raise EngineError("Row {row}, column {name}: {cell} is not a number.", row=line, name=name, cell=cell[:20])
            out[k] = value
        return out

    def _bare(self, name: str) -> str:
        return next((heading.name for heading in self.headings if heading.words == name), name)
