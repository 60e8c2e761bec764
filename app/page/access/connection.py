"""A connection of the server that cannot cost the others more than its share."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Collection
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed as ConnectionClosed
from websockets.exceptions import ProtocolError
from websockets.frames import OP_CONT, OP_PING, CloseCode, Frame
from websockets.http11 import Response
from websockets.protocol import State

from .access_policy import Refusal
from .flood_guard import AddressBook, ConnectionMeter
from .proxies import TrustedProxies, counted_address
from .request_head import METHOD, METHODS, RequestStart, read_head

SEND_TIMEOUT_S = 30.0  # s in which a connection must take something of what waits for it
TAB_TIMEOUT_S = 120.0  # s in which a WebSocket must open a tab; a page in a hidden window does so once it is shown
LINGER_S = 1.0  # s in which the last answer to a connection may go out
MAX_UNSENT_PONG_BYTES = 64 * 1024  # bytes that wait for a connection, above which its pings are not answered
SAID_GOODBYE = frozenset({1000, 1001, 1005})  # codes of a close by which a page says that it goes
TOO_MANY, NO_TAB = "has too many connections without a tab", "opened no tab"

log = logging.getLogger(__name__)


class Connection(ServerConnection):
    """A connection that is dropped when it takes nothing, sends too much or opens no tab.

    The library itself waits for ever, answers every ping into a buffer without a bound, and counts bytes of a message, not its
    pieces.
    """

    def __init__(self, addresses: AddressBook, protocol: Any, server: Any, forms: Collection[str] = (),
                 proxies: TrustedProxies | None = None, **options: Any) -> None:
        """A form may be posted to the paths of `forms`; `proxies` may say for whom they ask."""
        super().__init__(protocol, server, **options)
        self._proxies = proxies or TrustedProxies()
        self.touched = time.monotonic()
        self.method, self.form, self._forms = "GET", b"", forms
        self.dropped = False
        self._addresses, self._peer, self._address, self._waits = addresses, "", "", False
        self._meter, self._head = ConnectionMeter(), bytearray()
        self._reads_head = True
        self._deadline: asyncio.TimerHandle | None = None
        self._receive_frame: Callable[[Frame], None] = protocol.recv_frame
        protocol.recv_frame = self._count_frame

    # --- whose it is -----------------------------------------------------------------------------------------------
    @property
    def address(self) -> str:
        """Where it comes from, as a trusted proxy says or as the system does; one of IPv6 by its network."""
        return self._address

    @property
    def broke(self) -> bool:
        """Whether it ended without a word from its page, which then comes back."""
        return self.close_code not in SAID_GOODBYE

    def touch(self) -> None:
        """Somebody has done something on its page, or follows something there."""
        self.touched = time.monotonic()

    def open_tab(self) -> None:
        """The connection has a tab now."""
        self._meter.open_tab()
        self._stop_waiting()

    def wait_for_tab(self) -> None:
        """Drop the connection unless it opens a tab soon."""
        self._deadline = self.loop.call_later(TAB_TIMEOUT_S, self.drop, NO_TAB)

    def drop(self, reason: str) -> None:
        """End the connection now; one line in the log says why."""
        if self.dropped or self.protocol.state is State.CLOSED:
            return
        self.dropped = True
        log.warning("dropped a connection: %s %s", self._address, reason)
        if self.protocol.state is State.OPEN:
            self.protocol.fail(CloseCode.POLICY_VIOLATION, reason)
            self.send_data()
        self.transport.pause_reading()  # type: ignore[attr-defined]
        self.loop.call_later(LINGER_S, self.transport.abort)

    def _come_from(self, address: str) -> None:
        """Count the connection under the address that a proxy gives for it."""
        if address != self._address and self._waits:
            self._addresses.leave(self._address)
            self._address = address
            if not self._addresses.arrive(address):
                self.drop(TOO_MANY)

    def _stop_waiting(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None
        if self._waits:
            self._waits = False
            self._addresses.leave(self._address)

    # --- what asyncio calls ----------------------------------------------------------------------------------------
    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Count it, and turn it away where its address has too many."""
        super().connection_made(transport)
        peer = transport.get_extra_info("peername")
        self._peer = str(peer[0]) if isinstance(peer, tuple) else ""
        self._address, self._waits = counted_address(self._peer), True
        if not self._addresses.arrive(self._address):
            self.drop(TOO_MANY)

    def connection_lost(self, exc: Exception | None) -> None:
        """It is over."""
        self._stop_waiting()
        super().connection_lost(exc)
        vars(self.protocol).pop("recv_frame", None)  # which holds this connection

    def data_received(self, data: bytes) -> None:
        """Read the head of the request first, then what websockets reads."""
        if self.dropped:
            return
        if self._reads_head:
            self._head += data
            found = read_head(bytes(self._head), self._here(), self._forms)
            if found is None:
                return
            self._reads_head, self._head = False, bytearray()
            if isinstance(found, Refusal):
                self._refuse(found)
                return
            assert isinstance(found, RequestStart)
            self.method, self.form, data = found.method, found.form, found.data
            sender = self._proxies.sender(self._peer, found.fields)
            self._come_from(counted_address(sender))  # before a frame that came with the head is counted
        super().data_received(data)

    async def drain(self) -> None:
        """Wait until there is room again. Raises TimeoutError, upon which the library closes the connection."""
        left = self.transport.get_write_buffer_size()
        while True:
            try:
                async with asyncio.timeout(SEND_TIMEOUT_S):
                    return await super().drain()
            except TimeoutError:
                before, left = left, self.transport.get_write_buffer_size()
                if left >= before:
                    raise

    # --- frames and heads ------------------------------------------------------------------------------------------
    def _count_frame(self, frame: Frame) -> None:
        excess = self._meter.excess(len(frame.data), frame.opcode is OP_CONT)
        if excess is not None:
            self._addresses.drop(self._address)
            self.drop(excess)
            raise ProtocolError(excess)
        if frame.opcode is OP_PING and self.transport.get_write_buffer_size() > MAX_UNSENT_PONG_BYTES:
            return
        self._receive_frame(frame)

    def _refuse(self, refusal: Refusal) -> None:
        """Answer a request that websockets cannot read, and close."""
        self.dropped = True
        body = f"{refusal.words}\n".encode()
        headers = Headers({"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body)), "Connection": "close",
                           "Cache-Control": "no-store", "X-Content-Type-Options": "nosniff"})
        if refusal is METHOD:
            headers["Allow"] = ", ".join(METHODS)
        self.transport.write(Response(refusal.status, HTTPStatus(refusal.status).phrase, headers, body).serialize())
        self.transport.write_eof()
        self.loop.call_later(LINGER_S, self.transport.abort)

    def _here(self) -> str:
        name = self.transport.get_extra_info("sockname")
        if not isinstance(name, tuple):
            return "localhost"
        host = f"[{name[0].partition('%')[0]}]" if ":" in name[0] else name[0]
        return f"{host}:{name[1]}"
