"""Record a routine: what a device keeps, what it is given, its step; and run it in plain Python."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import CodeType
from typing import Any

import numpy as np

from ..text import Text
from .language import check_step

__all__ = ["Device", "Routine", "Table", "table"]


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


class Device:
    """A device that has just been switched on: `step` takes the readings of one sample, `tables` holds all its numbers.

    With `single` every number is a float32, and each operation rounds to it.
    """

    def __init__(self, routine: Routine, *, single: bool = False) -> None:
        self.routine, self._single = routine, single
        self._number: Callable[[float], Any] = np.float32 if single else float
        number = self._number
        self.tables: dict[str, list[Any]] = {each.name: [number(v) for v in each.values] for each in (*routine.constants, *routine.states)}
        self.tables |= {name: [number(0.0)] * length for name, length in routine.scratch.items()}
        self.tables |= {"y": [number(0.0)] * len(routine.y_names), "u": [number(0.0)] * len(routine.u_names)}
        self._names = {**self.tables, **routine.sizes, "sqrt": _single_root if single else math.sqrt,
                       "floor": np.floor if single else _floor}
        self._code: CodeType = compile(routine.source, f"<{routine.kind}>", "exec")

    def step(self, y: Sequence[float] | np.ndarray, u: Sequence[float] | np.ndarray = ()) -> list[float]:
        """Take the readings (NaN where one is missing) and, where the device does not drive, the inputs; gives the inputs."""
        number = self._number
        self.tables["y"][:] = [number(v) for v in y]
        if not self.routine.drives:
            self.tables["u"][:] = [number(v) for v in u]
        if self._single:
            with np.errstate(all="ignore"):
                exec(self._code, self._names)
        else:
            exec(self._code, self._names)
        return [float(v) for v in self.tables["u"]]

    def command(self, r: Sequence[float]) -> None:
        """Give the command r."""
        self.tables["r"][:] = [self._number(v) for v in r]

    def read(self, name: str) -> np.ndarray:
        """A table as it stands."""
        return np.array([float(v) for v in self.tables[name]])

    def run(self, y: np.ndarray, u: np.ndarray, r: np.ndarray | None = None, tables: Sequence[str] = ("xhat", "u"),
            ) -> dict[str, np.ndarray]:
        """Take one row of readings after the other; gives the named tables after each."""
        rows: dict[str, list[np.ndarray]] = {name: [] for name in tables}
        for k in range(len(y)):
            if r is not None:
                self.command(r[k])
            self.step(y[k], u[k])
            for name in tables:
                rows[name].append(self.read(name))
        return {name: np.array(found) for name, found in rows.items()}


def _floor(value: float) -> float:
    return float(math.floor(value)) if math.isfinite(value) else value


def _single_root(value: float | np.float32) -> np.float32:
    return np.sqrt(np.float32(value))
