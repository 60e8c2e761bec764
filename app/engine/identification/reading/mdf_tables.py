"""Read the chosen channels of an MDF file with asammdf, of the extra `records`."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np

from ...systems.errors import EngineError
from .clocks import Channel, channel_table, default_channels
from .tables import ArrayTable

if TYPE_CHECKING:
    from .record_reader import Asked

__all__ = ["mdf_table"]

CLOCKS = frozenset({"t", "time", "timestamps"})


def mdf_table(data: bytes, asked: Asked) -> ArrayTable:
    """The asked channels on the clock of the fastest output. Raises EngineError where asammdf is missing or cannot read the file."""
    try:
        from asammdf import MDF
    except ImportError as problem:
        raise EngineError('MDF files need asammdf; install it with pip install "observer-lab[records]".') from problem
    try:
        file = MDF(io.BytesIO(data))
    except Exception as problem:  # asammdf raises its own errors and those of its parts
        raise EngineError("This MDF file cannot be read; it may be cut off.") from problem
    there = [name for name in file.channels_db if name.lower() not in CLOCKS]
    inputs, outputs = default_channels(there, asked.inputs, asked.outputs)
    found = {name: file.get(name) for name in (*inputs, *outputs)}
    return channel_table({name: Channel(np.asarray(signal.timestamps, dtype=float), np.asarray(signal.samples, dtype=float),
                                        str(signal.unit or "")) for name, signal in found.items()}, inputs, outputs)
