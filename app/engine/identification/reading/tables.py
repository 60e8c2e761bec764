"""Define the columns of a file before they become a record: names, units, values and true row numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ...systems.errors import Phrase

__all__ = ["ArrayTable", "Choice", "Heading", "Table"]


@dataclass(frozen=True)
class Heading:
    """What the head says of a column: all its words, and name and unit apart; `bracketed` if the unit stood in brackets."""

    words: str
    name: str
    unit: str = ""
    bracketed: bool = False


@dataclass(frozen=True)
class Choice:
    """Which columns are time, inputs and outputs, by their places; `time` None where the rows are counted."""

    time: int | None
    inputs: tuple[int, ...]
    outputs: tuple[int, ...]


class Table(Protocol):
    """Columns of a file, of which each is parsed when it is asked for."""

    @property
    def headings(self) -> tuple[Heading, ...]:
        """One heading for each column."""
        ...

    @property
    def lines(self) -> np.ndarray:
        """The number of each row in the file, from 1."""
        ...

    @property
    def notes(self) -> tuple[Phrase, ...]:
        """What was done to the file."""
        ...

    def words(self, column: int) -> Sequence[str] | None:
        """The cells of a column as they are written, None where the file holds numbers."""
        ...

    def numbers(self, columns: Sequence[int]) -> np.ndarray:
        """Columns as numbers, NaN where missing. Raises EngineError for a cell that is none."""
        ...


@dataclass(frozen=True, eq=False)
class ArrayTable:
    """A table whose columns are numbers already, of a file that holds no text."""

    headings: tuple[Heading, ...]
    columns: tuple[np.ndarray, ...] = field(repr=False)
    notes: tuple[Phrase, ...] = ()

    @property
    def lines(self) -> np.ndarray:
        """Rows counted from 1."""
        return np.arange(1, len(self.columns[0]) + 1)

    def words(self, column: int) -> None:
        """No words: the file holds numbers."""
        return None

    def numbers(self, columns: Sequence[int]) -> np.ndarray:
        """Columns as numbers."""
        return np.column_stack([np.asarray(self.columns[k], dtype=float) for k in columns])
