"""Say where a request comes from, by the proxies that are trusted to tell it."""

from __future__ import annotations

import ipaddress
from collections.abc import Iterable
from dataclasses import dataclass

from websockets.datastructures import Headers

IPV6_PREFIX = 64  # bits of an IPv6 address that one household or office has for itself
Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Network = ipaddress.IPv4Network | ipaddress.IPv6Network


def counted_address(address: str) -> str:
    """By what an address is counted: one of IPv6 by its network of 64 bits, in which a machine takes any number of addresses."""
    found = _read(address)
    if isinstance(found, ipaddress.IPv6Address) and not found.is_loopback:
        return str(ipaddress.ip_network((found, IPV6_PREFIX), strict=False))
    return address if found is None else str(found)


@dataclass(frozen=True)
class TrustedProxies:
    """Those whose X-Forwarded-For is taken: all of this machine, and those in `networks`."""

    networks: tuple[Network, ...] = ()

    @classmethod
    def of(cls, networks: Iterable[str]) -> TrustedProxies:
        """Those in the networks of these words. Raises ValueError."""
        return cls(tuple(map(ipaddress.ip_network, networks)))

    def sender(self, peer: str, fields: Headers) -> str:
        """The address that a request comes from: the last one in X-Forwarded-For that is no trusted proxy, where one has sent it."""
        found = _read(peer)
        said = [part.strip() for value in fields.get_all("X-Forwarded-For") for part in value.split(",")]
        while found is not None and self._trusts(found) and said:
            before = _read(said.pop())
            if before is None:
                break
            found = before
        return peer if found is None else str(found)

    def _trusts(self, address: Address) -> bool:
        return address.is_loopback or any(address in network for network in self.networks)


def _read(words: str) -> Address | None:
    """An address; one of IPv4 that is written as IPv6 is the first."""
    try:
        found = ipaddress.ip_address(words.partition("%")[0])
    except ValueError:
        return None
    return (found.ipv4_mapped or found) if isinstance(found, ipaddress.IPv6Address) else found
