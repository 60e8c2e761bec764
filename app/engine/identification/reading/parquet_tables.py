"""Read the columns of a Parquet file with pyarrow, of the extra `records`."""

from __future__ import annotations

import io

import numpy as np

from ...systems.errors import EngineError
from .layout import heading_of
from .tables import ArrayTable, Heading

__all__ = ["parquet_table"]


def parquet_table(data: bytes) -> ArrayTable:
    """The columns of a Parquet file that hold numbers or times. Raises EngineError where pyarrow is missing or cannot read it."""
    try:
        import pyarrow as arrow
        import pyarrow.parquet as parquet
    except ImportError as problem:
        raise EngineError('Parquet files need pyarrow; install it with pip install "observer-lab[records]".') from problem
    try:
        table = parquet.read_table(io.BytesIO(data))
    except (arrow.ArrowException, OSError, ValueError) as problem:
        raise EngineError("This Parquet file cannot be read; it may be cut off.") from problem
    headings, columns = [], []
    for name in table.column_names:
        column, heading = table.column(name), heading_of(str(name))
        kind = column.type
        if arrow.types.is_timestamp(kind) or arrow.types.is_duration(kind):
            column, heading = column.cast(arrow.int64()), Heading(heading.words, heading.name, kind.unit, True)
        elif not (arrow.types.is_integer(kind) or arrow.types.is_floating(kind) or arrow.types.is_decimal(kind)):
            continue
        values = column.to_numpy()
        if heading.unit in ("s", "ms", "us", "ns") and values.dtype.kind == "i" and len(values):
            values = values - values[0]  # before it becomes a float: 64 bits hold no epoch in ns
        headings.append(heading)
        columns.append(np.asarray(values, dtype=float))
    if not columns:
        raise EngineError("This file has no columns of numbers.")
    return ArrayTable(tuple(headings), tuple(columns))
