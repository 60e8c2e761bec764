"""Run a routine in plain Python, in double or in single precision."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from types import CodeType
from typing import Any

import numpy as np

from .routine import Routine

__all__ = ["Device"]


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
