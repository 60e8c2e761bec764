"""Define a block diagram: blocks with their equations, wires with their signals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from ...text import NO_WORDS, Text, format_number, text
from .figure_record import Entry, FigureRecord, Part, Sheet, numbered

Point = tuple[float, float]
DIAGRAM = text("Diagram")  # the tab of diagrams
SIZE = 360.0, 232.0  # of the plane in which boxes and wires stand: across, and down from the top
MOST_MOMENTS = 121  # of a run that a diagram shows
USUAL, RUN_AWAY, ROUNDING = 4.0, 25.0, 1e-9  # medians; times that; share of a signal's size that is nothing but rounding


@dataclass(frozen=True)
class Block:
    """A block: its box (left, top, width, height), its name, its equation in LaTeX, and the knobs that a press on it sets, if any."""

    id: str
    box: tuple[float, float, float, float]
    name: Text | str
    law: str = ""
    press: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    pressed: Text = NO_WORDS  # what the press does, in words
    off: bool = False  # nothing comes out of it now


@dataclass(frozen=True, eq=False)
class Wire:
    """A signal of `values` (N,) or (N, m) over the run on its ways, each of which ends with an arrow, and where its name begins."""

    symbol: str
    ways: tuple[tuple[Point, ...], ...]
    at: Point
    values: np.ndarray
    unit: str = ""
    role: str = "plant"

    @property
    def sizes(self) -> np.ndarray:
        """The magnitudes (N, m) of its channels."""
        return np.abs(np.nan_to_num(np.asarray(self.values, dtype=float).reshape(len(self.values), -1)))

    @property
    def full(self) -> np.ndarray:
        """The size (m,) of each channel that is drawn thickest: the largest, or USUAL times the median where the signal runs away."""
        sizes = self.sizes
        held = len(sizes) - 1
        while held > 0 and np.array_equal(sizes[held], sizes[held - 1]):  # a run that has stopped is held to the end
            held -= 1
        moving, largest = sizes[:held + 1], sizes.max(axis=0)
        usual = USUAL * np.median(moving, axis=0)
        return np.asarray(np.where((usual > 0) & (largest > RUN_AWAY * usual), usual, np.where(largest > 0, largest, 1.0)))

    @property
    def shares(self) -> np.ndarray:
        """How thick the wire is at each time, 0 to 1: that of its largest channel."""
        return np.asarray(np.minimum(self.sizes / self.full, 1.0).max(axis=1, initial=0.0))

    @property
    def said(self) -> list[str]:
        """What stands beside the wire at each time: its value where it is one number, else how many numbers it is."""
        values = np.asarray(self.values, dtype=float)
        if values.ndim > 1 and values.shape[1] != 1:
            return [f"{self.symbol} ({values.shape[1]})"] * len(values)
        tiny = ROUNDING * float(self.full[0])
        numbers = [format_number(0.0 if abs(value) < tiny else float(value), ".3g") for value in values.ravel()]
        return [f"{self.symbol} = {number} {self.unit}".rstrip() for number in numbers]


@dataclass(frozen=True, eq=False)
class DiagramFigure(FigureRecord):
    """Blocks and wires over the times `t` (N,) of a run; `marks` are signs that stand in it, `sums` where signals are added."""

    id: str
    title: Text
    t: np.ndarray
    blocks: tuple[Block, ...]
    wires: tuple[Wire, ...]
    sums: tuple[Point, ...] = ()
    marks: tuple[tuple[str, Point], ...] = ()
    caption: Text = NO_WORDS
    tab: Text = DIAGRAM

    @property
    def moments(self) -> np.ndarray:
        """The samples that are shown: all of a short run."""
        return np.unique(np.linspace(0, len(self.t) - 1, min(len(self.t), MOST_MOMENTS)).astype(int))

    @property
    def kind(self) -> str:
        return "diagram"

    def axes(self, language: str = "en") -> tuple[str, str]:
        return "t [s]", ""

    def table(self, language: str = "en") -> Sheet:
        """A row a time, a column a signal."""
        names, columns = ["t [s]"], [np.asarray(self.t, dtype=float)]
        for wire in self.wires:
            values = np.asarray(wire.values, dtype=float).reshape(len(self.t), -1)
            ends = [""] if values.shape[1] == 1 else [f" {k + 1}" for k in range(values.shape[1])]
            names += [f"{wire.symbol}{end} [{wire.unit}]" if wire.unit else f"{wire.symbol}{end}" for end in ends]
            columns += list(values.T)
        return names, [tuple(map(float, row)) for row in zip(*columns, strict=True)]

    def entries(self) -> Iterator[Entry]:
        names, rows = self.table()
        for k, name in enumerate(names[1:], 1):
            yield from ((name, float(row[0]), row[k], "") for row in rows)

    def parts(self) -> Iterator[Part]:
        yield from (("x", "t [s]"), *numbered("block", (block.name for block in self.blocks)),
                    *numbered("wire", (wire.symbol for wire in self.wires)))

    def pressed(self, part: str) -> Mapping[str, object]:
        return next((block.press for block in self.blocks if block.id == part), {})

    @property
    def has_presses(self) -> bool:
        return any(block.press for block in self.blocks)
