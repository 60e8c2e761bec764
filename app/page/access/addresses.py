"""Find the port and address of the server, and whether other machines can reach it."""

from __future__ import annotations

import errno
import ipaddress
import socket
from urllib.parse import urlsplit

from .patient_listener import PatientListener

HIGHEST = 65535
TRIES = 1000  # ports that are tried, the one asked for first
EVERYWHERE = ("0.0.0.0", "::")


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

