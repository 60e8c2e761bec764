"""Read and write viser's messages so that none of them can end a connection.

viser's own loops stop at the first message that they cannot decode or encode, and the connection ends with them.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import zstandard

from ...text import replace_surrogates
from ..access.connection import Connection

QUIET = frozenset({"LocalStorageGetItemResponseMessage"})  # what a page sends by itself
ALIGNMENT = 8  # bytes to which viser's page wants each array to begin
log = logging.getLogger(__name__)


async def read_messages(connection: Any, handle: Callable[[Any], None], kinds: Any) -> None:
    """Hand on every message of a connection until it closes; what viser cannot decode is left out, with one line in the log."""
    while True:
        words = await connection.recv()
        try:
            message = kinds.deserialize(words)
        except Exception as problem:
            log.warning("left out a message that cannot be read (%s)", type(problem).__name__)
            continue
        if isinstance(connection, Connection) and type(message).__name__ not in QUIET:
            connection.touch()
        handle(message)


def pack_any_text(encode: Callable[[Any], bytes]) -> Callable[[Any], bytes]:
    """`encode`, with characters that UTF-8 cannot hold replaced where it meets some."""
    def pack(content: Any) -> bytes:
        try:
            return encode(content)
        except UnicodeEncodeError:
            return encode(sendable(content))
    return pack


def pack(messages: Sequence[Any]) -> bytes:
    """Messages as viser's own server packs a batch: two lengths, the messages compressed, then the arrays at multiples of eight."""
    arrays: list[memoryview] = []
    written = [message.as_serializable_dict(arrays) for message in messages]
    inner = ENCODE({"messages": written, "timestampSec": time.perf_counter(),
                    "binaryBufferLengths": [array.nbytes for array in arrays]})
    pressed = zstandard.ZstdCompressor(level=1).compress(inner)
    out = bytearray(len(inner).to_bytes(8, "little") + len(pressed).to_bytes(8, "little") + pressed)
    for array in arrays:
        out += bytes(-len(out) % ALIGNMENT)
        out += array
    return bytes(out)


def log_failed_callback(problem: BaseException) -> None:
    """Write to the log what viser would print of a callback that failed."""
    log.error("a callback failed", exc_info=problem)


def sendable(content: Any) -> Any:
    """Plain data with characters that UTF-8 cannot hold replaced."""
    match content:
        case str():
            return replace_surrogates(content)
        case dict():
            return {sendable(key): sendable(value) for key, value in content.items()}
        case list() | tuple():
            return [sendable(value) for value in content]
    return content


ENCODE = pack_any_text(msgspec.msgpack.encode)
