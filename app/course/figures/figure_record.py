"""Define what every kind of figure says of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Self, TypeAlias

from ...text import Text, label_in_language

Cell = str | float
Sheet = tuple[list[str], Sequence[Sequence[Cell]]]  # heads, and rows below them
Entry = tuple[str, float, Cell, Cell]  # of a table of all figures: series, x, y, value
Part = tuple[str, Text | str]  # the place of a sentence in a figure, and the sentence
PinnedFigure: TypeAlias = "tuple[int, Text, FigureRecord]"  # the place of a pin, its name, and its figure of the same id


class FigureRecord(ABC):
    """What every kind of figure says of itself: page, export, JSON, screen reader and print ask here."""

    id: str
    title: Text
    caption: Text
    tab: Text

    @property
    @abstractmethod
    def kind(self) -> str:
        """Its kind in a table of all figures."""

    @abstractmethod
    def axes(self, language: str = "en") -> tuple[str, str]:
        """What stands at its axes, with units; nothing where it has none."""

    @abstractmethod
    def table(self, language: str = "en") -> Sheet:
        """Its data as a table of its own."""

    @abstractmethod
    def entries(self) -> Iterator[Entry]:
        """Its data as rows of a table of all figures, names in English."""

    @abstractmethod
    def parts(self) -> Iterator[Part]:
        """Its words beside title and caption, each with its place."""

    def words(self) -> Iterator[Part]:
        """All that it says in words: tab, title, caption, then axes, names, heads and cells."""
        yield from (("tab", self.tab), ("title", self.title), ("caption", self.caption))
        yield from self.parts()

    def pressed(self, part: str) -> Mapping[str, object]:
        """The knobs that a press on a part of the figure sets; none where nothing can be pressed."""
        return {}

    @property
    def has_presses(self) -> bool:
        """Whether a part of the figure can be pressed."""
        return False

    def with_pins(self, pinned: Sequence[PinnedFigure]) -> Self:
        """With thin curves and hollow marks of pinned designs, where these differ from what is drawn anyway; itself if it has none."""
        return self


def numbered(name: str, all_words: Iterable[Text | str]) -> Iterator[Part]:
    """Words with their number behind the name of their place."""
    return ((f"{name}.{number}", words) for number, words in enumerate(all_words, 1))


def distinct(names: list[str]) -> list[str]:
    """The names, later ones of a kind with a number behind them: a, b, a (2)."""
    counts = [names[:k].count(name) for k, name in enumerate(names)]
    return [f"{name} ({count + 1})" if count else name for name, count in zip(names, counts, strict=True)]


class WordTable(FigureRecord):
    """A figure whose data are heads and rows of words."""

    @abstractmethod
    def cells(self) -> tuple[tuple[Text, ...], tuple[tuple[Text | str, ...], ...]]:
        """The heads, and the rows below them."""

    def axes(self, language: str = "en") -> tuple[str, str]:
        return "", ""

    def table(self, language: str = "en") -> Sheet:
        heads, rows = self.cells()
        return [head(language) for head in heads], [tuple(label_in_language(cell, language) for cell in row) for row in rows]

    def entries(self) -> Iterator[Entry]:
        heads, rows = self.table()
        for i, row in enumerate(rows):
            yield from ((name, float(i), "", cell) for name, cell in zip(heads, row, strict=True))

    def parts(self) -> Iterator[Part]:
        heads, rows = self.cells()
        yield from numbered("column", heads)
        for number, row in enumerate(rows, 1):
            yield from numbered(f"row.{number}", row)
