"""Bound what one connection and one address may cost: messages, bytes, fragments, idle time.

An honest page sends some 20 messages a second, at most 50 while its camera turns; every bound stands well above that.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

MESSAGES_PER_S, MESSAGE_BURST = 200.0, 1000.0  # of one connection that has a tab
BYTES_PER_S, BYTE_BURST = 256 * 1024.0, 8 * 1024 * 1024.0  # of one connection that has a tab
EARLY_PER_S, EARLY_BURST = 20.0, 60.0  # messages of one connection that has no tab yet
EARLY_BYTES_PER_S, EARLY_BYTE_BURST = 64 * 1024.0, 1024 * 1024.0  # bytes of one connection that has no tab yet
DROPS_PER_S, DROP_BURST = 0.1, 5.0  # connections of one address that may be dropped before it must wait
MAX_FRAGMENTS = 256  # frames of one message; a browser cuts half a megabyte into a few dozen
SMALL_FRAGMENT_BYTES = 1024  # bytes below which a fragment counts as a message of its own
MAX_WAITING = 512  # connections without a tab of one address: a course of 300 opens its pages behind one router
MAX_ADDRESSES = 4096  # addresses that are remembered
FRAGMENTS = f"sent a message in more than {MAX_FRAGMENTS} pieces"
MESSAGES, BYTES = "sent messages faster than any page does", "sent more bytes than any page does"


class TokenBucket:
    """An allowance that grows by `per_s` each second up to `burst`."""

    def __init__(self, per_s: float, burst: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._per_s, self._burst, self._clock = per_s, burst, clock
        self._left, self._since = burst, clock()

    def take(self, amount: float) -> bool:
        """Use some of the allowance; False, and nothing used, where less is left."""
        now = self._clock()
        self._left = min(self._burst, self._left + (now - self._since) * self._per_s)
        self._since = now
        if amount > self._left:
            return False
        self._left -= amount
        return True


class ConnectionMeter:
    """Count what one connection has sent; `excess` says why it must be dropped."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._messages = TokenBucket(EARLY_PER_S, EARLY_BURST, clock)
        self._bytes = TokenBucket(EARLY_BYTES_PER_S, EARLY_BYTE_BURST, clock)
        self._fragments = 0

    def open_tab(self) -> None:
        """The connection has a tab now: it may send what a page in use sends."""
        self._messages = TokenBucket(MESSAGES_PER_S, MESSAGE_BURST, self._clock)
        self._bytes = TokenBucket(BYTES_PER_S, BYTE_BURST, self._clock)

    def excess(self, size_bytes: int, continues: bool) -> str | None:
        """Count one frame of that size, which begins a message or `continues` one; why it is too much, None where it is not."""
        self._fragments = self._fragments + 1 if continues else 0
        if self._fragments > MAX_FRAGMENTS:
            return FRAGMENTS
        if not (continues and size_bytes >= SMALL_FRAGMENT_BYTES) and not self._messages.take(1.0):
            return MESSAGES
        return None if self._bytes.take(size_bytes) else BYTES


@dataclass
class AddressRecord:
    """What is known of one address: its connections without a tab, and how many of its connections may still be dropped."""

    drops: TokenBucket
    waiting: int = 0
    blocked_until: float = 0.0


class AddressBook:
    """Connections by address; a few thousand addresses are remembered, those without a connection forgotten first."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._records: dict[str, AddressRecord] = {}

    def arrive(self, address: str) -> bool:
        """Count a connection without a tab; False where the address has too many already. It is counted all the same."""
        record = self._of(address)
        record.waiting += 1
        return record.waiting <= MAX_WAITING

    def leave(self, address: str) -> None:
        """A connection without a tab has ended, or has its tab now."""
        record = self._of(address)
        record.waiting = max(0, record.waiting - 1)

    def drop(self, address: str) -> None:
        """A connection of this address was dropped; after a few, the address must wait before it opens another."""
        record = self._of(address)
        if not record.drops.take(1.0):
            record.blocked_until = self._clock() + 1.0 / DROPS_PER_S

    def must_wait(self, address: str) -> bool:
        """Whether this address may open no WebSocket now."""
        record = self._records.get(address)
        return record is not None and self._clock() < record.blocked_until

    def _of(self, address: str) -> AddressRecord:
        record = self._records.get(address)
        if record is None:
            if len(self._records) >= MAX_ADDRESSES:
                idle = [known for known, held in self._records.items() if not held.waiting]
                for known in idle[: MAX_ADDRESSES // 2]:
                    del self._records[known]
            record = self._records[address] = AddressRecord(TokenBucket(DROPS_PER_S, DROP_BURST, self._clock))
        return record
