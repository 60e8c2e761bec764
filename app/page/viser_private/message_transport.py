"""Read and write viser's messages so that none of them can end a connection.

viser's own loops stop at the first message that they cannot decode or encode, and the connection ends with them.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from types import TracebackType
from typing import Any

from ...text import replace_surrogates

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
        handle(message)


def pack_any_text(encode: Callable[[Any], bytes]) -> Callable[[Any], bytes]:
    """`encode`, with characters that UTF-8 cannot hold replaced where it meets some."""
    def pack(content: Any) -> bytes:
        try:
            return encode(content)
        except UnicodeEncodeError:
            return encode(_sendable(content))
    return pack


def log_failed_callback(kind: type[BaseException], problem: BaseException, trace: TracebackType | None) -> None:
    """Write to the log what viser would print of a callback that failed."""
    log.error("a callback failed", exc_info=(kind, problem, trace))


def _sendable(content: Any) -> Any:
    match content:
        case str():
            return replace_surrogates(content)
        case dict():
            return {_sendable(key): _sendable(value) for key, value in content.items()}
        case list() | tuple():
            return [_sendable(value) for value in content]
    return content
