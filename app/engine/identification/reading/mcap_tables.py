"""Read the chosen fields of the messages in an MCAP file with mcap, of the extra `records`."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...systems.errors import EngineError
from .clocks import Channel, channel_table, default_channels
from .ros_messages import ros_decoder
from .tables import ArrayTable

if TYPE_CHECKING:
    from .record_reader import Asked

__all__ = ["mcap_table"]

MOST_FIELDS = 500  # of all messages
DEEPEST = 6


def mcap_table(data: bytes, asked: Asked) -> ArrayTable:
    """The asked fields, called as in `/motor.current`, by the log time.

    Raises EngineError where mcap is missing or cannot read the file.
    """
    try:
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
    except ImportError as problem:
        raise EngineError('MCAP files need mcap; install it with pip install "observer-lab[records]".') from problem
    times: dict[str, list[int]] = {}
    values: dict[str, list[float]] = {}
    decoders: dict[int, Any] = {}
    try:
        for schema, channel, message in make_reader(io.BytesIO(data)).iter_messages():
            if channel.id not in decoders:
                decoders[channel.id] = json.loads if channel.message_encoding == "json" else ros_decoder(channel.message_encoding, schema)
            decode = decoders[channel.id]
            for name, value in () if decode is None else _fields(channel.topic, decode(message.data), 0):
                if len(times) < MOST_FIELDS or name in times:
                    times.setdefault(name, []).append(message.log_time)
                    values.setdefault(name, []).append(value)
    except (McapError, ValueError, EOFError, KeyError, OSError) as problem:
        raise EngineError("This MCAP file cannot be read; it may be cut off.") from problem
    inputs, outputs = default_channels(list(times), asked.inputs, asked.outputs)
    start = min(times[name][0] for name in (*inputs, *outputs))
    return channel_table({name: Channel(np.array([at - start for at in times[name]], dtype=float) / 1e9, np.array(values[name]))
                          for name in (*inputs, *outputs)}, inputs, outputs)


def _fields(name: str, value: Any, depth: int) -> Iterator[tuple[str, float]]:
    """All numbers of a message with the path to them."""
    if isinstance(value, bool) or value is None or depth > DEEPEST:
        return
    if isinstance(value, int | float):
        yield name, float(value)
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _fields(f"{name}.{key}", inner, depth + 1)
    elif isinstance(value, list | tuple | np.ndarray):
        for k, inner in enumerate(list(value)[:64]):
            yield from _fields(f"{name}.{k}", inner if not isinstance(inner, np.generic) else inner.item(), depth + 1)
    elif hasattr(type(value), "__slots__"):
        for key in type(value).__slots__:
            yield from _fields(f"{name}.{key}", getattr(value, key, None), depth + 1)
