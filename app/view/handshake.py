"""How connections are taken: behind the gate, with small messages, with safe headers, and not for ever.

Stands in the place of `websockets.asyncio.server.serve`, which viser calls without asking anybody.
"""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Callable
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response

from .gate import Gate, Refusal, policy

log = logging.getLogger(__name__)

PART = 512 * 1024  # bytes of one part of an upload, as viser's page cuts it
LARGEST = PART + 64 * 1024  # bytes of one message
STALLED = 30.0  # s in which a connection must take something of what waits for it


class Connection(ServerConnection):
    """A connection that is dropped when nothing of what waits for it has gone out for a while.

    The library itself waits for ever: a connection that sends but never reads keeps its session, and its ping is never
    missed, because it waits in the same queue.
    """

    async def drain(self) -> None:
        """Wait until there is room again. Raises TimeoutError, upon which the library closes the connection."""
        left = self.transport.get_write_buffer_size()
        while True:
            try:
                async with asyncio.timeout(STALLED):
                    return await super().drain()
            except TimeoutError:
                before, left = left, self.transport.get_write_buffer_size()
                if left >= before:
                    raise


def guarded(listener: socket.socket, gate: Gate, refused: Callable[[Refusal], None],
            ready: Callable[[], bool]) -> Callable[..., Any]:
    """`serve` on a socket that listens already; whom the gate refuses gets an answer and no connection."""
    def server(handler: Any, host: str, port: int, *, process_request: Any, **options: Any) -> Any:
        def ask(connection: ServerConnection, request: Request) -> Response | None:
            refusal = gate.refusal(request.headers) if ready() else Refusal(503, "The server is starting; try again.")
            if refusal is None:
                return process_request(connection, request)
            refused(refusal)
            return connection.respond(refusal.status, refusal.words + "\n")

        options |= {"max_size": LARGEST, "create_connection": Connection, "process_response": safe_headers}
        return serve(handler, sock=listener, process_request=ask, **options)
    return server


def safe_headers(connection: ServerConnection, request: Request, response: Response) -> None:
    """What the page may load and call, and that a browser must not guess what a file is."""
    hosts = request.headers.get_all("Host")
    if response.status_code == 200 and len(hosts) == 1:  # past the gate, so it is a name and a port
        response.headers["Content-Security-Policy"] = policy(hosts[0])
        response.headers["Referrer-Policy"] = "same-origin"
        response.headers["Cache-Control"] = "no-cache"
    response.headers["X-Content-Type-Options"] = "nosniff"
