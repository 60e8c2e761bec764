"""Compute numbers, lists and the figures of a tab when they are first read.

A draft whose hidden figures come later answers a hand sooner; whoever reads it whole finds what would have been there at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Generic, Literal, TypeVar, overload

from ..text import Text
from .figures.records import Figure

T = TypeVar("T")
D = TypeVar("D")


class LazyValue(Generic[T]):
    """A value that is made when it is first looked at, and kept."""

    def __init__(self, make: Callable[[], T]) -> None:
        self._make: Callable[[], T] | None = make
        self._made: T

    @property
    def value(self) -> T:
        """The value. Raises what making it raises."""
        make = self._make
        if make is not None:
            self._made = make()
            self._make = None
        return self._made


class LazyMap(Mapping[str, T]):
    """Numbers or matrices by name, computed together when one is looked at that is not `known`."""

    def __init__(self, make: Callable[[], Mapping[str, T]], known: Mapping[str, T] = MappingProxyType({})) -> None:
        self._all, self.known = LazyValue(make), known

    def __getitem__(self, name: str) -> T:
        return self.known[name] if name in self.known else self._all.value[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all.value)

    def __len__(self) -> int:
        return len(self._all.value)


def merge_lazily(numbers: Mapping[str, T], more: Mapping[str, T]) -> Mapping[str, T]:
    """`numbers` and `more`, which count where both have a name; those that nobody has looked at yet are still made later."""
    known = numbers.known if isinstance(numbers, LazyMap) else numbers
    return LazyMap(lambda: {**numbers, **more}, {**known, **more})


def replace_keeping_cache(record: D, **changes: object) -> D:
    """A frozen record with other values in fields on which no cached property of it rests: what those have found stays found."""
    changed = replace(record, **changes)  # type: ignore[type-var]
    for name, value in vars(record).items():
        if name not in record.__dataclass_fields__:  # type: ignore[attr-defined]
            changed.__dict__[name] = value
    return changed


class LazySequence(Sequence[T]):
    """A list that is made as a whole when it is first looked at."""

    def __init__(self, make: Callable[[], Iterable[T]]) -> None:
        self._all = LazyValue(lambda: tuple(make()))

    @overload
    def __getitem__(self, index: int) -> T: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[T, ...]: ...
    def __getitem__(self, index: int | slice) -> T | tuple[T, ...]:
        return self._all.value[index]

    def __len__(self) -> int:
        return len(self._all.value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and tuple(self) == tuple(other)

    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True, eq=False)
class TabFigures:
    """Figures of one tab, which come first where it is `open`; `always` those that stand on the stage too, and `late` those of
    which nobody reads anything while a knob moves."""

    tab: Text
    figures: LazySequence[Figure]
    first: Literal["open", "always", "late"]


def tab_figures(tab: Text, make: Callable[[], Iterable[Figure]], first: Literal["open", "always", "late"] = "open") -> TabFigures:
    """Figures of a tab that `make` makes."""
    return TabFigures(tab, LazySequence(make), first)


class FigureSet(LazySequence[Figure]):
    """All figures of an outcome, leaf by leaf."""

    def __init__(self, *leaves: TabFigures) -> None:
        super().__init__(lambda: (figure for each in leaves for figure in each.figures))
        self.leaves = leaves

    def front(self, tab: str | None) -> tuple[Figure, ...]:
        """The figures that come first with this tab open, by its English name; the first tab for None or a name that there is not."""
        names = [each.tab("en") for each in self.leaves]
        open_now = tab if tab in names else names[0]
        return tuple(figure for name, each in zip(names, self.leaves, strict=True)
                     if each.first == "always" or (each.first == "open" and name == open_now) for figure in each.figures)


def complete_figures(figures: Sequence[Figure], undisturbed: Callable[[], bool]) -> bool:
    """Make all figures, leaf by leaf; False where that was disturbed between two."""
    for each in figures.leaves if isinstance(figures, FigureSet) else ():
        if not undisturbed():
            return False
        len(each.figures)
    return True
