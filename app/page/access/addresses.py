"""Listen at a port and address, with a file in reserve, and say who can reach the server."""

from __future__ import annotations

import errno
import ipaddress
import logging
import os
import socket
from typing import Any
from urllib.parse import urlsplit

HIGHEST = 65535
TRIES = 1000  # ports that are tried, the one asked for first
EVERYWHERE = ("0.0.0.0", "::")
OUT_OF_FILES = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})

log = logging.getLogger(__name__)


def listen(host: str, port: int, exact: bool = False) -> socket.socket:
    """A listening socket on that port or, unless it must be that `exact` one, the next free one; 0 is any free one. Raises OSError."""
    family, address = _resolved(host)
    last: OSError | None = None
    for attempt in range(port, min(port + (1 if exact else TRIES), HIGHEST + 1)) if port else (0,):
        try:
            found = socket.create_server((address, attempt), family=family, backlog=200,
                                         dualstack_ipv6=address == "::" and socket.has_dualstack_ipv6())
            return PatientListener(fileno=found.detach())
        except OSError as problem:
            last = problem
            if problem.errno != errno.EADDRINUSE:
                raise
    assert last is not None
    raise last


def is_public(host: str) -> bool:
    """Whether other machines can reach a server on that address. Raises OSError."""
    return not ipaddress.ip_address(_resolved(host)[1].partition("%")[0]).is_loopback


def url(host: str, port: int) -> str:
    """What to type into a browser on this machine; IPv6 in brackets, a name for an address that means all addresses."""
    shown = "localhost" if host in EVERYWHERE else f"[{host}]" if ":" in host else host
    return f"http://{shown}:{port}"


def is_reachable(address: str) -> bool:
    """Whether another machine could open an address: its host does not name the machine itself."""
    host = urlsplit(address).hostname or ""
    try:
        return not ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host != "localhost"


def _resolved(host: str) -> tuple[socket.AddressFamily, str]:
    try:
        family, _, _, _, address = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[0]
    except UnicodeError as problem:
        raise OSError(f"{host[:80]} is not a name") from problem
    return family, str(address[0])


class PatientListener(socket.socket):
    """A listener that keeps one file in reserve. When no other is left, it accepts with that one, and closes the connection.

    asyncio itself reports an error for every place of the queue of a listener that cannot accept, a hundred at a time.
    """

    def __init__(self, fileno: int) -> None:
        super().__init__(fileno=fileno)
        self._reserve: int | None = os.open(os.devnull, os.O_RDONLY)

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection and who it is from. Raises ConnectionAbortedError where one was turned away."""
        try:
            return super().accept()
        except OSError as problem:
            if problem.errno not in OUT_OF_FILES:
                raise
            if self._reserve is None:
                raise
            self._turn_away(self._reserve)
            raise ConnectionAbortedError from problem

    def close(self) -> None:
        """Close it, and the file in reserve."""
        super().close()
        reserve, self._reserve = self._reserve, None
        if reserve is not None:
            os.close(reserve)

    def _turn_away(self, reserve: int) -> None:
        log.warning("a connection was turned away: too many files are open")
        os.close(reserve)
        self._reserve = None
        try:
            super().accept()[0].close()
            self._reserve = os.open(os.devnull, os.O_RDONLY)
        except OSError:  # another thread took the file; the connection waits
            return
