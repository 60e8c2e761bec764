"""A record: what was applied and what was measured, row by row over time, with names and units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..systems.arrays import as_numbers, frozen
from ..systems.errors import EngineError, Phrase, ShapeError, phrase
from ..systems.gates.argument_checks import NAME, items, names, pair, passed
from ..systems.records import record as a_record

__all__ = ["MAX_ROWS", "Record"]

MAX_ROWS = 1_000_000
REGULAR = 1e-3  # of a step: how far the steps of a regular record may differ, as printed times do
FEWEST_ROWS = 8
MAX_CHANNELS = 10


@a_record()
class Record:
    """Inputs u (n_t, m) and outputs y (n_t, p) at the times t (n_t,) in s; y is NaN where no measurement came.

    input_names, output_names (u1 …, y1 … if left out) and `units`, pairs (name, unit). `notes`: sentences about what was
    done to the record. Raises ShapeError, EngineError for times that do not grow, for u with NaN, for other lengths.
    """

    t: np.ndarray
    u: np.ndarray
    y: np.ndarray
    input_names: tuple[str, ...] = ()
    output_names: tuple[str, ...] = ()
    units: tuple[tuple[str, str], ...] = ()
    notes: tuple[Phrase, ...] = ()

    def __post_init__(self) -> None:
        passed(self, input_names=names, output_names=names, units=items(pair(NAME, NAME)), notes=items(NAME))
        t = np.array(as_numbers(self.t, "t"), dtype=float).reshape(-1)
        u, y = (self._columns(value, name, len(t)) for value, name in ((self.u, "u"), (self.y, "y")))
        if not FEWEST_ROWS <= len(t) <= MAX_ROWS:
            raise EngineError("A record needs {low} to {high} rows; this one has {count}.",
                              low=FEWEST_ROWS, high=MAX_ROWS, count=len(t))
        if not y.shape[1]:
            raise EngineError("A record needs at least one output y.")
        if np.isnan(u).any():
            raise EngineError("u holds NaN; every input must be known.")
        late = np.flatnonzero(~(np.diff(t) > 0))
        if late.size:
            raise EngineError("The times must grow from row to row; row {row} is not later than the row before.", row=int(late[0]) + 2)
        if not np.isfinite(y).any(axis=0).all():
            raise EngineError("An output has no measurement at all; leave it out.")
        for name, value in (("t", t), ("u", u), ("y", y)):
            object.__setattr__(self, name, frozen(value))
        object.__setattr__(self, "input_names", self.input_names or tuple(f"u{i + 1}" for i in range(u.shape[1])))
        object.__setattr__(self, "output_names", self.output_names or tuple(f"y{i + 1}" for i in range(y.shape[1])))
        if (len(self.input_names), len(self.output_names)) != (u.shape[1], y.shape[1]):
            raise ShapeError("A record needs one name for each input and one for each output.")

    @staticmethod
    def _columns(value: object, name: str, rows: int) -> np.ndarray:
        array = np.array(as_numbers(value, name, missing=True), dtype=float)
        array = array.reshape(rows, 0) if not array.size else array[:, None] if array.ndim == 1 else array
        if array.ndim != 2 or len(array) != rows or array.shape[1] > MAX_CHANNELS:
            raise ShapeError("{name} must have one row for each time and at most {most} columns; its shape is {array_shape}.",
                             name=name, most=MAX_CHANNELS, array_shape=array.shape)
        return array

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.t)

    @property
    def dt(self) -> float:
        """The step in s, 0 where the steps differ by more than a thousandth.

        >>> Record([0, 1, 2, 3, 4, 5, 6, 7], [], np.ones(8)).dt
        1.0
        """
        steps = np.diff(self.t)
        middle = float(np.median(steps))
        regular = np.abs(steps - middle).max() <= REGULAR * middle
        return float(self.t[-1] - self.t[0]) / len(steps) if regular else 0.0  # written times are rounded, their mean step hardly

    @property
    def size(self) -> Phrase:
        """Step, rows and length in words.

        >>> Record([0, 1, 2, 3, 4, 5, 6, 7], [], np.ones(8)).size
        'Step 1 s, 8 rows, 8 s.'
        """
        if self.dt:
            return phrase("Step {step:.6g} s, {rows} rows, {span:.6g} s.", step=self.dt, rows=f"{self.rows:,}", span=self.rows * self.dt)
        steps = np.diff(self.t)
        return phrase("Irregular steps from {low:.3g} to {high:.3g} s, {rows} rows, {span:.6g} s.", low=float(steps.min()),
                      high=float(steps.max()), rows=f"{self.rows:,}", span=float(self.t[-1] - self.t[0]))

    def unit(self, name: str) -> str:
        """The unit of a column, "" where none is said."""
        return dict(self.units).get(name, "")

    def part(self, first: int, last: int) -> Record:
        """The rows first … last − 1."""
        return replace(self, t=self.t[first:last], u=self.u[first:last], y=self.y[first:last])

    def noted(self, *notes: Phrase, **changed: np.ndarray) -> Record:
        """The same with other arrays and further notes."""
        return replace(self, notes=(*self.notes, *notes), **changed)
