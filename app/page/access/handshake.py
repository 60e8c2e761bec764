"""Answer each request: let a connection in, send the page, or say in one sentence why not.

Stands in the place of `websockets.asyncio.server.serve`, which viser calls without asking anybody.
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import json
import logging
import re
import socket
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import partial
from http import HTTPStatus
from typing import Any, Protocol
from urllib.parse import parse_qs

from websockets.asyncio.server import serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from .access_policy import AccessPolicy, Refusal, asks_for_websocket
from .connection import Connection
from .flood_guard import AddressBook
from .metrics import KIND, metrics_text
from .page_headers import PageHeaders
from .places import PLACE_FIELD, Visitor
from .proxies import TrustedProxies
from .tokens import AccessToken


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


UPLOAD_PART_BYTES = 512 * 1024  # bytes of one part of an upload, as viser's page cuts it
MAX_MESSAGE_BYTES = UPLOAD_PART_BYTES + 64 * 1024  # bytes of one message
WHERE = ("/", "/index.html")  # the page and its WebSocket; a proxy may show us its second name
HEALTH, METRICS = "/health", "/metrics"
RETRY_AFTER_S = 10  # s after which whoever found no place asks again
READY_TIMEOUT_S = 5.0  # s in which a server that is starting stands
VERSION_MISMATCH = 1002  # the close code that tells viser's page that its version differs
STARTING = Refusal(503, "The server is starting; try again.")
NO_PAGE = Refusal(404, "There is no such page here.")
WAIT = Refusal(429, "Too much came from this address; wait ten seconds and try again.")
TOKEN_REQUIRED = Refusal(401, "This server asks for its access token, as ?token=… in the address or as Authorization: Bearer ….")
NEVER = re.compile(r"q\s*=\s*0(?:\.0*)?", re.IGNORECASE)  # the weight of a coding that a browser does not take

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
        """The page, or that it is still the one the browser has."""
        if self.tag in request.headers.get_all("If-None-Match"):
            return Response(304, "Not Modified", Headers(ETag=self.tag))
        packs = takes_gzip(request)
        body = self.packed if packs else self.plain
        headers = Headers({"Content-Type": "text/html; charset=utf-8", "Content-Length": str(len(body)), "ETag": self.tag,
                           "Vary": "Accept-Encoding", "Cache-Control": "no-cache"})
        if packs:
            headers["Content-Encoding"] = "gzip"
        return Response(200, "OK", headers, body)


def takes_gzip(request: Request) -> bool:
    """Whether a browser takes gzip: it names it, and not with the weight 0."""
    named = [part.partition(";") for value in request.headers.get_all("Accept-Encoding") for part in value.split(",")]
    weights = [weight.strip() for name, _, weight in named if name.strip().lower() in ("gzip", "x-gzip")]
    return bool(weights) and not any(NEVER.fullmatch(weight) for weight in weights)


@dataclass(frozen=True)
class DoorRequest:
    """A request at a door of its own: path and question, fields, and the form that came with it. `cookie` is the field Set-Cookie that
    lets a browser in, "" where the server asks for no word."""

    path: str
    headers: Headers
    form: bytes
    cookie: str
    frames: tuple[str, ...] = ()


class Doors(Protocol):
    """Paths beside the page, which decide themselves who may pass."""

    @property
    def paths(self) -> Collection[str]:
        """Where they are; forms may be posted there."""
        ...

    async def answer(self, request: DoorRequest) -> Response:
        """The answer; it keeps the loop from nothing."""
        ...


@dataclass(frozen=True)
class AdmissionControl:
    """Who is let in, and what the others are told: through `gate`, knowing the word of `access` if one is needed.

    `refused` hears of each whom the gate turns away; `health` is what HEALTH answers; `full` is the page for whoever comes while
    there is no place, else empty; `stranger` is the page for who does not know the word; `headers` stand on every answer.
    Whoever shows the word of `presenter` presents to a room. `doors` are open to who does not know the word.
    """

    gate: AccessPolicy
    access: AccessToken | None
    refused: Callable[[Refusal], None]
    health: Callable[[], Mapping[str, object]]
    full: Callable[[Visitor], str]
    stranger: str
    headers: PageHeaders = field(default_factory=PageHeaders)
    presenter: AccessToken | None = None
    doors: Doors | None = None
    proxies: TrustedProxies = field(default_factory=TrustedProxies)
    key_of: Callable[[str], int] = lambda ticket: 0  # the key in the ticket of a tab that comes back

    def visitor(self, request: Request, address: str) -> Visitor:
        """Who sends a request from an address, as far as places go."""
        tickets = parse_qs(request.path.partition("?")[2]).get(PLACE_FIELD, [])
        presents = self.presenter is not None and self.presenter.knows_token(request.headers, request.path)
        return Visitor(address, self.key_of(tickets[0]) if tickets else 0, presents)

    @property
    def forms(self) -> frozenset[str]:
        """The paths to which a form may be posted."""
        return frozenset(() if self.doors is None else self.doors.paths)

    async def answer_at_door(self, request: Request, form: bytes) -> Response:
        """The answer to a request at one of the doors."""
        head = request.headers
        refusal = self.gate.refusal(head)
        if refusal is not None:
            self.refused(refusal)
        if refusal is not None or self.doors is None:
            answer = plain_answer(refusal or NO_PAGE)
        else:
            cookie = "" if self.access is None else self._cookie(self.access, head)
            answer = await self.doors.answer(DoorRequest(request.path, head, form, cookie, self.headers.frames))
        self.headers.complete(answer, next(iter(head.get_all("Host")), ""))
        return answer

    def answer(self, request: Request, page: PackedPage, ready: bool, address: str = "") -> Response | None:
        """The answer to a request from an address, None where it asks for a WebSocket and gets it."""
        answer = self._answer(request, page, ready, address)
        if answer is not None:
            self.headers.complete(answer, next(iter(request.headers.get_all("Host")), ""))
        return answer

    def hold_back(self) -> Response:
        """The answer to an address of which too much came."""
        answer = _with(plain_answer(WAIT), "Retry-After", str(RETRY_AFTER_S))
        self.headers.complete(answer, "")
        return answer

    def _answer(self, request: Request, page: PackedPage, ready: bool, address: str) -> Response | None:
        head, access, path = request.headers, self.access, request.path.partition("?")[0]
        refusal = self.gate.refusal(head, access is not None and access.has_token_header(head))
        if refusal is not None:
            self.refused(refusal)
            return plain_answer(refusal)
        if access is not None and not access.knows_token(head, request.path):
            answer = plain_answer(TOKEN_REQUIRED) if asks_for_websocket(head) else _html(TOKEN_REQUIRED.status, self.stranger)
            return _with(answer, "WWW-Authenticate", "Bearer")
        if not ready:
            return _with(plain_answer(STARTING), "Retry-After", str(RETRY_AFTER_S))
        if path == HEALTH and not asks_for_websocket(head):
            return text_answer(200, json.dumps(self.health()), "application/json")
        if path == METRICS and not asks_for_websocket(head):
            return text_answer(200, metrics_text(self.health()), KIND)
        if path not in WHERE:
            return plain_answer(NO_PAGE)
        for word in (access, self.presenter):
            if word is not None and word.shown(request.path) and not asks_for_websocket(head):
                return self._exchange(word, request)
        if busy := self.full(self.visitor(request, address)):
            return _with(_html(503, busy), "Retry-After", str(RETRY_AFTER_S))
        return None if asks_for_websocket(head) else page.answer(request)

    def _exchange(self, access: AccessToken, request: Request) -> Response:
        """Give the cookie for the word in the address, and send the browser to the address without it."""
        answer = _with(text_answer(303, "The word is in a cookie now.", "text/plain; charset=utf-8"), "Location",
                       access.address_without(request.path))
        return _with(answer, "Set-Cookie", self._cookie(access, request.headers))

    def _cookie(self, access: AccessToken, head: Headers) -> str:
        return access.cookie_in_frames() if self.headers.frames else access.cookie(head)


def serve_guarded(listener: socket.socket, page: PackedPage, admission: AdmissionControl, ready: Callable[[], bool],
                  protocol: str) -> Callable[..., Any]:
    """`serve` on a socket that listens already; whom the admission does not let in gets an answer and no connection.

    A page of another version than `protocol` names is told so by the code of the close.
    """
    addresses, forms = AddressBook(), admission.forms

    async def ask(connection: Connection, request: Request) -> Response | None:
        end = time.monotonic() + READY_TIMEOUT_S
        while not ready() and time.monotonic() < end:  # who comes first waits: a proxy would show a refusal to a person
            await asyncio.sleep(READY_TIMEOUT_S / 100)
        if connection.protocol.eof_sent:  # whoever asked has left meanwhile, and the library takes an answer to nobody for a fault
            raise asyncio.CancelledError
        held_back = asks_for_websocket(request.headers) and addresses.must_wait(connection.address)
        if connection.dropped or held_back:
            answer: Response | None = admission.hold_back()
        elif request.path.partition("?")[0] in forms and not asks_for_websocket(request.headers):
            answer = await admission.answer_at_door(request, connection.form)
        else:
            answer = admission.answer(request, page, ready(), connection.address)
        if answer is not None:
            answer.headers["Connection"] = "close"
            answer.body = b"" if connection.method == "HEAD" else answer.body
        return answer

    def server(handler: Any, host: str, port: int, **options: Any) -> Any:
        async def enter(connection: Connection) -> None:
            if connection.subprotocol != protocol:
                log.warning("a page of another version was turned away: %.40s instead of %s", connection.subprotocol, protocol)
                await connection.close(VERSION_MISMATCH, f"This server is of version {protocol}.")
                return
            connection.wait_for_tab()
            await handler(connection)

        made = partial(Connection, addresses, forms=forms, proxies=admission.proxies)
        options |= {"max_size": MAX_MESSAGE_BYTES, "create_connection": made, "process_request": ask, "logger": log,
                    "server_header": None}
        return serve(enter, sock=listener, **options)
    return server


def plain_answer(refusal: Refusal) -> Response:
    """A refusal as an answer in plain text."""
    return text_answer(refusal.status, refusal.words, "text/plain; charset=utf-8")


def _with(answer: Response, name: str, value: str) -> Response:
    answer.headers[name] = value
    return answer


def _html(status: int, words: str) -> Response:
    return text_answer(status, words, "text/html; charset=utf-8")


def text_answer(status: int, words: str, kind: str) -> Response:
    """An answer of that kind of text, which nobody keeps."""
    body = f"{words}\n".encode()
    headers = Headers({"Content-Type": kind, "Cache-Control": "no-store", "Content-Length": str(len(body))})
    return Response(status, HTTPStatus(status).phrase, headers, body)
