"""Read the columns of a .mat file: vectors t, u, y, or matrices with one column for each signal."""

from __future__ import annotations

import io
import zlib
from typing import TYPE_CHECKING

import numpy as np

from ...systems.errors import EngineError
from .moments import TIME_NAMES, time_heading
from .tables import ArrayTable, Heading

if TYPE_CHECKING:
    from .record_reader import Asked

__all__ = ["mat_table"]


def mat_table(data: bytes, asked: Asked) -> ArrayTable:
    """The columns of a .mat file of level 4 or 5. Raises EngineError for version 7.3, and where the lengths do not agree."""
    if data.startswith(b"\x89HDF") or data[512:516] == b"\x89HDF":
        raise EngineError("This .mat file is of version 7.3; save it in MATLAB with the option -v7.")
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        found = loadmat(io.BytesIO(data), squeeze_me=False, struct_as_record=True)
    except (MatReadError, ValueError, TypeError, KeyError, EOFError, NotImplementedError, zlib.error, OSError, IndexError) as problem:
        raise EngineError("This .mat file cannot be read; save it in MATLAB with the option -v7.") from problem
    arrays = {name: value for name, value in found.items() if not name.startswith("__") and isinstance(value, np.ndarray)}
    if {"A", "B", "C"} <= set(arrays) or {"num", "den"} <= set(arrays):
        raise EngineError("This .mat file holds a plant (A, B, C) and no record of t, u and y; open it with --plant.")
    structs = [name for name, value in arrays.items() if value.dtype.names and value.size == 1]
    numeric = {name: value for name, value in arrays.items() if value.dtype.kind in "iufb" and value.ndim == 2 and value.size > 1}
    if not numeric and len(structs) == 1:
        inside = arrays[structs[0]].reshape(-1)[0]
        numeric = {name: np.atleast_2d(inside[name]) for name in inside.dtype.names
                   if isinstance(inside[name], np.ndarray) and inside[name].dtype.kind in "iufb" and inside[name].size > 1}
    if not numeric:
        raise EngineError("This .mat file has no numeric variables such as t, u and y.")
    return _columns(numeric, asked)


def _columns(numeric: dict[str, np.ndarray], asked: Asked) -> ArrayTable:
    """One column for each vector, and for each column of a matrix; variables of another length are left out unless they are asked for."""
    wanted = {asked.time.split("[")[0].strip(), *asked.inputs, *asked.outputs} - {""}
    rows = _rows(numeric)
    headings, columns, left = [], [], []
    for name, value in numeric.items():
        if rows not in value.shape:
            if name in wanted:
                raise EngineError("Variable {name} has the size {size} and the time has {rows} rows; they must agree.", name=name,
                                  size="×".join(map(str, value.shape)), rows=rows)
            left.append(name)
            continue
        table = np.asarray(value if value.shape[0] == rows else value.T, dtype=float)
        for k in range(table.shape[1]):
            words = name if table.shape[1] == 1 else f"{name}{k + 1}"
            headings.append(Heading(words, words))
            columns.append(table[:, k])
    for name in ("t", "u", "y"):
        if name in left:
            raise EngineError("Variable {name} has the size {size} and the time has {rows} rows; they must agree.", name=name,
                              size="×".join(map(str, numeric[name].shape)), rows=rows)
    return ArrayTable(tuple(headings), tuple(columns))


def _rows(numeric: dict[str, np.ndarray]) -> int:
    """The length of the time, else of the longest variable."""
    for name, value in numeric.items():
        if time_heading(Heading(name, name)).name.lower() in TIME_NAMES:
            return value.size
    return max(max(value.shape) for value in numeric.values())
