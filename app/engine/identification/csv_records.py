"""Read a record from a CSV file: columns t, u…, y… with units in the head, or columns chosen by name."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..systems.errors import EngineError
from ..systems.gates.argument_checks import NAME, instance, names, takes
from .records import MAX_ROWS, Record

__all__ = ["load_record", "read_record"]

MAX_BYTES = 200_000_000
HEAD = re.compile(r"^\s*(?P<name>[^\[(]*?)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?\s*$")
SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0}.items
MISSING = frozenset({"", "nan", "na", "n/a", "null", "none", "-"})
DATE = re.compile(r"^\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d(\.\d+)?)?)?Z?$")


@takes(path=instance(str, os.PathLike), time=NAME, inputs=names, outputs=names)
def load_record(path: str | os.PathLike[str], *, time: str = "", inputs: Sequence[str] = (), outputs: Sequence[str] = ()) -> Record:
    """The record in a CSV file; see `read_record`. Raises EngineError where it cannot be read."""
    name = Path(path).name
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise OSError
        with open(path, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as problem:
        raise EngineError("The file {name} cannot be read; check its name and place.", name=name) from problem
    if len(data) > MAX_BYTES:
        raise EngineError("The file {name} is larger than {size} MB; keep fewer rows or fewer digits.", name=name, size=MAX_BYTES // 10**6)
    try:
        return read_record(data.decode("utf-8-sig"), time=time, inputs=inputs, outputs=outputs)
    except UnicodeDecodeError as problem:
        raise EngineError("The file {name} is not UTF-8 text; save it as CSV in UTF-8.", name=name) from problem


@takes(text=NAME, time=NAME, inputs=names, outputs=names)
def read_record(text: str, *, time: str = "", inputs: Sequence[str] = (), outputs: Sequence[str] = ()) -> Record:
    """The record in a CSV text with one head line: names, and units as in `u1 [V]`.

    Without choice, t (or time) is the time, u… are the inputs, y… the outputs. `time`, `inputs`, `outputs` choose other columns
    by name. Separated by comma, semicolon, tab or blanks; a decimal comma where semicolons or tabs separate. Empty cells and NaN
    are missing. Times: seconds, or in the unit of the head; or dates as 2026-11-25 13:05:00. Raises EngineError.

    >>> read_record("t [s],u [V],y [m]\\n" + "".join(f"{k},1,{k * k}\\n" for k in range(9))).dt
    1.0
    """
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if len(lines) < 2:
        raise EngineError("The file holds no rows; it needs a head line such as t [s],u1 [V],y1 [m] and one row for each time.")
    if len(lines) - 1 > MAX_ROWS:
        raise EngineError("The file holds {count} rows; at most {most} can be read.", count=len(lines) - 1, most=MAX_ROWS)
    mark = _separator(lines[0])
    head = [_named(cell) for cell in _cells(lines[0], mark)]
    columns = [name for name, _ in head]
    double = next((name for name in columns if columns.count(name) > 1), None)
    if double is not None:
        raise EngineError("Two columns are called {name}; give each its own name in the first line.", name=double)
    time, inputs, outputs = _chosen(columns, time, tuple(inputs), tuple(outputs))
    units = dict(head)
    body = lines[1:]
    clock, factor = columns.index(time), _factor(units[time], time)
    table = _table(body, mark, columns, None if DATE.match(_cells(body[0], mark)[clock].strip('"')) is None else clock)
    t = table[:, clock] * factor
    if np.isnan(t).any():
        raise EngineError("Row {row} has no time; every row needs one.", row=int(np.flatnonzero(np.isnan(t))[0]) + 2)
    late = np.flatnonzero(~(np.diff(t) > 0))
    if late.size:
        raise EngineError("The times must grow from row to row; row {row} is not later than the row before.", row=int(late[0]) + 3)
    u, y = (table[:, [columns.index(name) for name in chosen]] for chosen in (inputs, outputs))
    hole = np.argwhere(~np.isfinite(u))
    if hole.size:
        raise EngineError("Input {name} is missing in row {row}; every input must be known.",
                          name=inputs[hole[0, 1]], row=int(hole[0, 0]) + 2)
    y = np.where(np.isfinite(y), y, np.nan)
    said = tuple((name, units[name]) for name in (*inputs, *outputs) if units[name])
    return Record(t - t[0], u, y, inputs, outputs, said)


def _separator(head: str) -> str:
    """What separates the cells of the first line."""
    return next((mark for mark in (";", "\t", ",") if mark in head), " ")


def _cells(line: str, mark: str) -> list[str]:
    return line.split() if mark == " " else [cell.strip() for cell in line.split(mark)]


def _named(cell: str) -> tuple[str, str]:
    found = HEAD.match(cell.strip().strip('"'))
    return (cell, "") if found is None else (found["name"] or "", found["unit"] or "")


def _chosen(columns: list[str], time: str, inputs: tuple[str, ...],
            outputs: tuple[str, ...]) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
    """The columns of time, inputs and outputs: those asked for, else t, u… and y…."""
    listed = ", ".join(columns)[:200]
    for name in (*([time] if time else ()), *inputs, *outputs):
        if name not in columns:
            raise EngineError("There is no column {name}; the file has {columns}.", name=name, columns=listed)
    time = time or next((name for name in columns if name.lower() in ("t", "time")), "")
    if not time:
        raise EngineError("No column is called t or time; the file has {columns}: say which one is the time.", columns=listed)
    if not inputs and not outputs:
        inputs = tuple(name for name in columns if re.match(r"[uU](\d|_|$)", name))
        outputs = tuple(name for name in columns if re.match(r"[yY](\d|_|$)", name))
    if not outputs:
        raise EngineError("No column is an output y; the file has {columns}: say which ones are outputs.", columns=listed)
    if time in inputs or time in outputs or set(inputs) & set(outputs):
        raise EngineError("A column can be only one of time, input and output; choose each once.")
    return time, inputs, outputs


def _factor(unit: str, name: str) -> float:
    found = dict(SECONDS()).get(unit)
    if found is None:
        raise EngineError("The unit {unit} of {name} is not one of s, ms, us, ns, min, h and d.", unit=unit, name=name)
    return found


def _table(body: list[str], mark: str, columns: list[str], dates: int | None) -> np.ndarray:
    """All numbers, NaN where a cell is empty; quickly where the file is plain, cell by cell where it is not."""
    if dates is None and mark == ",":
        try:
            table = np.loadtxt(io.StringIO("\n".join(body)), delimiter=",", ndmin=2)
            if table.shape[1] == len(columns):
                return table
        except ValueError:
            pass  # empty cells or something to name
    out = np.empty((len(body), len(columns)))
    for k, line in enumerate(body):
        cells = _cells(line, mark)
        if len(cells) != len(columns):
            raise EngineError("In row {row} the number of values differs from that of the names in the first line: {count} instead of "
                              "{columns}.", row=k + 2, count=len(cells), columns=len(columns))
        for j, cell in enumerate(cells):
            out[k, j] = _date(cell, k) if j == dates else _number(cell, mark, k, columns[j])
    return out


def _number(cell: str, mark: str, row: int, name: str) -> float:
    cell = cell.strip('"').strip()
    if cell.lower() in MISSING:
        return np.nan
    try:
        return float(cell.replace(",", ".") if mark in ";\t" else cell)
    except ValueError as problem:
        raise EngineError("Row {row}, column {name}: {cell} is not a number.", row=row + 2, name=name, cell=cell[:20]) from problem


def _date(cell: str, row: int) -> float:
    cell = cell.strip('"').strip()
    if DATE.match(cell) is None:
        raise EngineError("Row {row}: {cell} is not a date and time such as 2026-11-25 13:05:00.", row=row + 2, cell=cell[:30])
    try:
        return np.datetime64(cell.rstrip("Z"), "ns").astype(np.int64) / 1e9
    except ValueError as problem:
        raise EngineError("Row {row}: {cell} is not a date and time such as 2026-11-25 13:05:00.", row=row + 2, cell=cell[:30]) from problem
