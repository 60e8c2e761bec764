"""Record a routine: what a device keeps, what it is given, and its step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..text import Text
from .language import check_step

__all__ = ["Routine", "Table", "table"]


@dataclass(frozen=True, eq=False)
class Table:
    """Numbers under one name, a matrix row by row; `shape` is (rows, columns), `note` says in English what they are."""

    name: str
    values: tuple[float, ...]
    shape: tuple[int, int]
    note: str = ""


def table(name: str, values: object, note: str = "") -> Table:
    """The table of a matrix or of a list of numbers."""
    array = np.asarray(values, dtype=float)
    rows, columns = array.shape if array.ndim == 2 else (1, array.size)
    return Table(name, tuple(float(v) for v in array.ravel()), (rows, columns), note)


@dataclass(frozen=True, eq=False)
class Routine:
    """What a device does each `period` seconds with the readings y and the inputs u.

    `constants` never change, `states` begin at their values, `scratch` gives names to room for one step. The estimate that belongs to the
    readings just taken stands in `xhat`. With `drives` the step computes u, else u is what acted on the plant. `watched` names the tables
    that a test compares, `rule` says how the design was sampled, `x_names` what the estimate holds.
    """

    kind: str
    period: float
    sizes: Mapping[str, int]
    constants: tuple[Table, ...]
    states: tuple[Table, ...]
    scratch: Mapping[str, int]
    source: str
    y_names: tuple[str, ...]
    u_names: tuple[str, ...]
    x_names: tuple[str, ...]
    drives: bool
    watched: tuple[str, ...]
    rule: Text

    def __post_init__(self) -> None:
        check_step(self.source, self.sizes, self.lengths)

    @cached_property
    def lengths(self) -> Mapping[str, int]:
        """The length of every table that the step may name."""
        named = {each.name: len(each.values) for each in (*self.constants, *self.states)}
        return {**named, **self.scratch, "y": len(self.y_names), "u": len(self.u_names)}

    @property
    def commanded(self) -> bool:
        """Whether a command r can be given."""
        return any(each.name == "r" for each in self.states)
