"""Decide from the head of a request who may speak to the server.

A page of another site reaches a server on this machine in two ways. It calls it by its address: then the page's own name
stands in Origin. Or its name is made to point here (DNS rebinding): then that name stands in Host. Both are looked at.
"""

from __future__ import annotations

import ipaddress
import re
import socket
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol
from urllib.parse import urlsplit

AUTHORITY = re.compile(r"(\[[0-9A-Fa-f:.]{2,45}\]|[\w.-]{1,253})(?::(\d{1,5}))?", re.ASCII)
CAME_BY = "Came-By"  # in which our page says under which origin its browser knows it: a proxy may have rewritten Host
SINGLE_HEADERS = ("Host", "Origin", "Upgrade", CAME_BY)  # two of these, and two readers may believe two different things
PORTS = (("http", 80), ("https", 443))
POLICY = ("default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; style-src 'unsafe-inline'; "
          "img-src data: blob:; font-src data:; worker-src blob: data:; "
          "connect-src 'self' data: blob: ws://{host} wss://{host}; base-uri 'none'; form-action {forms}; object-src 'none'; "
          "frame-ancestors {frames}")


class RequestHead(Protocol):
    """The head of a request, as far as the gate reads it."""

    def get_all(self, key: str) -> list[str]:
        """Every value of a field, in order."""
        ...


@dataclass(frozen=True)
class Refusal:
    """Why a request is turned away: an HTTP status and one sentence."""

    status: int
    words: str


@dataclass(frozen=True)
class AccessPolicy:
    """The names that this server answers to: `own`, those `given` for it, and every name of loopback.

    A given name has its port, None where it is the usual one of http or https: a page from another port is another site's.

    On an address that others can reach (`public`) every address in figures passes too: a page cannot take one for its name.
    """

    own: frozenset[str]
    given: frozenset[tuple[str, int | None]]
    public: bool

    @classmethod
    def of(cls, host: str, public: bool, names: Iterable[str] = ()) -> AccessPolicy:
        """The gate of a server that listens on `host`, also called by `names`. Raises ValueError at what is no name."""
        given = frozenset(found if (found := _split(each))[0] else (_named(each), None) for each in names)
        if "" in {name for name, _ in given}:
            raise ValueError("a name is letters, digits, dots and dashes, with a port or without")
        return cls(frozenset(map(_named, (host, socket.gethostname()) if public else (host,))), given, public)

    def refusal(self, head: RequestHead, vouched: bool = False) -> Refusal | None:
        """Why a request is refused, None when it may pass. One that is `vouched` for may come under any name: no page sent it."""
        for field in SINGLE_HEADERS:
            if len(head.get_all(field)) > 1:
                return Refusal(400, f"The request has two fields {field}.")
        host = next(iter(head.get_all("Host")), "")
        name, _ = _split(host)
        if not name:
            return Refusal(400, "The request does not say which host it is for.")
        if not vouched and not self._answers_to(name):
            return Refusal(403, f"This server does not answer to the name {name[:80]}; if that is its name, start it with "
                                f"--allow-host {name[:80]}.")
        origin = next(iter(head.get_all("Origin")), None)
        if origin is not None and asks_for_websocket(head) and not self._our_page(origin, host):
            return Refusal(403, f"A page of {origin[:80]} may not speak to this server.")
        came_by = next(iter(head.get_all(CAME_BY)), None)
        if came_by is not None and not self._our_page(came_by, host):
            return Refusal(421, f"This server does not know the name {came_by[:80]}; start it with --allow-host and that name.")
        return None

    def _answers_to(self, name: str) -> bool:
        if name in self.own | {given for given, _ in self.given} | {"localhost"}:
            return True
        address = _address(name)
        return address is not None and (self.public or address.is_loopback)

    def _our_page(self, origin: str, host: str) -> bool:
        """Whether a page of that origin is ours: it comes from the host that is spoken to, or from a name and port that were given.

        A proxy may put another Host in front of us; the Origin then still has the name that people use.
        """
        try:
            scheme, authority = urlsplit(origin)[:2]
        except ValueError:
            return False
        usual = dict(PORTS).get(scheme)
        name, port = _split(authority)
        if usual is None or not name or origin.lower() != f"{scheme}://{authority}".lower():  # an origin has no path
            return False
        mine, my_port = _split(host)
        came_from = name, port or usual
        return came_from == (mine, my_port or usual) or came_from in {(given, its or usual) for given, its in self.given}


def asks_for_websocket(head: RequestHead) -> bool:
    """Whether the request asks for a WebSocket."""
    return any("websocket" in value.lower() for value in head.get_all("Upgrade"))


def content_policy(host: str, frames: Iterable[str] = (), forms: str = "'none'") -> str:
    """What a page that came under this Host may load and call: itself, whatever its address bar names; which sites, `frames`,
    may show it inside theirs; and where its `forms` may go.

    A site is a name, which must come over TLS, or an origin such as http://localhost:8888.

    viser's page connects to any address that stands behind `?websocket=` in its own, and runs what comes from there.
    """
    allowed = " ".join(site if "://" in site else f"https://{site}" for site in frames) or "'none'"
    return POLICY.format(host=host, frames=allowed, forms=forms)


def _split(authority: str) -> tuple[str, int | None]:
    """Name and port of `name:port`; an empty name where it is none."""
    found = AUTHORITY.fullmatch(authority)
    if found is None:
        return "", None
    port = None if found[2] is None else int(found[2])
    return _named(found[1]), port


def _named(name: str) -> str:
    """One spelling of a name or an address; empty where it is none."""
    bare = name[1:-1] if name.startswith("[") and name.endswith("]") else name
    address = _address(bare)
    if address is not None:
        return str(address)
    return bare.lower().removesuffix(".") if re.fullmatch(r"[\w.-]{1,253}", bare, re.ASCII) else ""


def _address(name: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(name)
    except ValueError:
        return None
