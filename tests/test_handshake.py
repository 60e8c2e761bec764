"""A connection that takes nothing of what waits for it is given up; a slow one is not."""

from __future__ import annotations

import asyncio
from collections import deque
from types import SimpleNamespace
from typing import Any

import pytest

from observer_lab.page.access import connection as connections
from observer_lab.page.access import handshake
from observer_lab.page.access.connection import Connection
from observer_lab.page.access.proxies import TrustedProxies


def waiting(*sizes: int) -> tuple[Connection, deque[int]]:
    """A connection whose buffer is full and has these sizes whenever somebody looks."""
    left = deque(sizes)
    connection = Connection.__new__(Connection)
    connection.paused, connection.drain_waiters = True, deque()
    connection.transport = SimpleNamespace(  # type: ignore[assignment]
        is_closing=lambda: False, get_write_buffer_size=lambda: left.popleft() if len(left) > 1 else left[0])
    return connection, left


@pytest.mark.parametrize(("sizes", "looks"), [((5, 5), 2), ((5, 6), 2), ((5, 4, 3, 3), 4)])
def test_a_connection_is_given_up_once_nothing_goes_out(sizes: tuple[int, ...], looks: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connections, "SEND_TIMEOUT_S", 0.01)
    connection, left = waiting(*sizes)

    async def drain() -> None:
        connection.loop = asyncio.get_running_loop()
        await connection.drain()
    with pytest.raises(TimeoutError):
        asyncio.run(drain())
    assert len(sizes) == looks and len(left) == 1, "as long as something goes out it is waited for"


def test_nobody_is_answered_who_has_left_while_it_waited(monkeypatch: pytest.MonkeyPatch) -> None:
    """websockets takes an answer to a closed connection for a fault of the program, and would say so in the log."""
    given: dict[str, Any] = {}
    monkeypatch.setattr(handshake, "serve", lambda enter, **options: given.update(options))
    reception: Any = SimpleNamespace(forms=frozenset(), proxies=TrustedProxies())
    handshake.serve_guarded(None, None, reception, lambda: True, "any")(None, "", 0)  # type: ignore[arg-type]
    with pytest.raises(asyncio.CancelledError):
        asyncio.run(given["process_request"](SimpleNamespace(protocol=SimpleNamespace(eof_sent=True)), None))
