"""Accept connections: check access, bound message sizes, set safe headers, drop stalled clients.

Stands in the place of `websockets.asyncio.server.serve`, which viser calls without asking anybody.
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import json
import logging
import socket
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from .access_policy import AccessPolicy, Refusal, asks_for_websocket, content_policy
from .tokens import AccessToken

UPLOAD_PART_BYTES = 512 * 1024  # bytes of one part of an upload, as viser's page cuts it
MAX_MESSAGE_BYTES = UPLOAD_PART_BYTES + 64 * 1024  # bytes of one message
SEND_TIMEOUT_S = 30.0  # s in which a connection must take something of what waits for it
WHERE = ("/", "/index.html")  # the page; a proxy may show us its second name
HEALTH = "/health"
RETRY_AFTER_S = 10  # s after which whoever found no place asks again
READY_TIMEOUT_S = 5.0  # s in which a server that is starting stands
STARTING = Refusal(503, "The server is starting; try again.")
TOKEN_REQUIRED = Refusal(401, "This server asks for its access token, as ?token=… in the address or as Authorization: Bearer ….")


class OneLineFilter(logging.Filter):
    """What a stranger sent costs one line in the log: no traceback, and nothing for a handshake that was none."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the record is written down."""
        if record.getMessage() == "opening handshake failed":
            return False
        if record.exc_info and record.exc_info[1] is not None:
            record.msg, record.args = f"{record.getMessage()} ({type(record.exc_info[1]).__name__})", ()
            record.exc_info = None
        return True


log = logging.getLogger(__name__)
log.addFilter(OneLineFilter())


@dataclass(frozen=True)
class PackedPage:
    """The page, packed once and kept in memory: there is no folder to fill up, to leave behind or to walk out of."""

    plain: bytes
    packed: bytes
    tag: str

    @classmethod
    def of(cls, text: str) -> PackedPage:
        """The page with that text."""
        plain = text.encode("utf-8")
        return cls(plain, gzip.compress(plain, mtime=0), f'"{hashlib.sha256(plain).hexdigest()[:20]}"')

    def answer(self, request: Request) -> Response:
        """The page, or that it is still the one the browser has; 404 for any other path."""
        if request.path.partition("?")[0] not in WHERE:
            return _plain(404, "There is no such page here.")
        if self.tag in request.headers.get_all("If-None-Match"):
            return Response(304, "Not Modified", Headers(ETag=self.tag))
        packs = any("gzip" in value for value in request.headers.get_all("Accept-Encoding"))
        body = self.packed if packs else self.plain
        headers = Headers({"Content-Type": "text/html; charset=utf-8", "Content-Length": str(len(body)), "ETag": self.tag,
                           "Vary": "Accept-Encoding", "Cache-Control": "no-cache", "Referrer-Policy": "same-origin",
                           "Content-Security-Policy": content_policy(request.headers["Host"])})
        if packs:
            headers["Content-Encoding"] = "gzip"
        return Response(200, "OK", headers, body)


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
                async with asyncio.timeout(SEND_TIMEOUT_S):
                    return await super().drain()
            except TimeoutError:
                before, left = left, self.transport.get_write_buffer_size()
                if left >= before:
                    raise


@dataclass(frozen=True)
class AdmissionControl:
    """Who is let in, and what the others are told: through `gate`, knowing the word of `access` if one is needed.

    `refused` hears of each whom the gate turns away; `health` is what HEALTH answers; `full` is the page for whoever comes while
    there is no place, else empty; `stranger` is the page for who does not know the word.
    """

    gate: AccessPolicy
    access: AccessToken | None
    refused: Callable[[Refusal], None]
    health: Callable[[], Mapping[str, object]]
    full: Callable[[], str]
    stranger: str

    def answer(self, request: Request, page: PackedPage, ready: bool) -> Response | None:
        """The answer to a request, None where it asks for a WebSocket and gets it."""
        head, access = request.headers, self.access
        refusal = self.gate.refusal(head, access is not None and access.has_token_header(head))
        if refusal is not None:
            self.refused(refusal)
            return _plain(refusal.status, refusal.words)
        if access is not None and not access.knows_token(head, request.path):
            return _with(
                _html(TOKEN_REQUIRED.status, self.stranger, request)
                if not asks_for_websocket(head)
                else _plain(TOKEN_REQUIRED.status, TOKEN_REQUIRED.words),
                ("WWW-Authenticate", "Bearer"),
            )
        if not ready:
            return _plain(STARTING.status, STARTING.words)
        if request.path.partition("?")[0] == HEALTH and not asks_for_websocket(head):
            return _answer(200, json.dumps(self.health()), "application/json")
        if busy := self.full():
            return _with(_html(503, busy, request), ("Retry-After", str(RETRY_AFTER_S)))
        if asks_for_websocket(head):
            return None
        answer = page.answer(request)
        return _with(answer, ("Set-Cookie", access.cookie(head))) if access is not None and access.shown(request.path) else answer


def serve_guarded(listener: socket.socket, page: PackedPage, reception: AdmissionControl, ready: Callable[[], bool]) -> Callable[..., Any]:
    """`serve` on a socket that listens already; whom the reception does not let in gets an answer and no connection."""
    async def ask(connection: ServerConnection, request: Request) -> Response | None:
        end = time.monotonic() + READY_TIMEOUT_S
        while not ready() and time.monotonic() < end:  # who comes first waits: a proxy would show a refusal to a person
            await asyncio.sleep(READY_TIMEOUT_S / 100)
        return reception.answer(request, page, ready())

    def server(handler: Any, host: str, port: int, **options: Any) -> Any:
        options |= {"max_size": MAX_MESSAGE_BYTES, "create_connection": Connection, "process_request": ask, "logger": log}
        return serve(handler, sock=listener, **options)
    return server


def _with(answer: Response, field: tuple[str, str]) -> Response:
    name, value = field
    answer.headers[name] = value
    return answer


def _html(status: int, words: str, request: Request) -> Response:
    return _with(_answer(status, words, "text/html; charset=utf-8"), ("Content-Security-Policy", content_policy(request.headers["Host"])))


def _plain(status: int, words: str) -> Response:
    return _answer(status, words, "text/plain; charset=utf-8")


def _answer(status: int, words: str, kind: str) -> Response:
    body = f"{words}\n".encode()
    headers = Headers({"Content-Type": kind, "Cache-Control": "no-store", "Content-Length": str(len(body)),
                       "X-Content-Type-Options": "nosniff"})
    return Response(status, HTTPStatus(status).phrase, headers, body)
