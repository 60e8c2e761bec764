"""Give out the places for tabs, counted by all workers in shared memory.

Whoever presents always has one, and so has a tab that comes back. When few places are left, newcomers from one address get a fair share.
Each row is written by its own worker alone; the parent writes those of a worker that has ended.
"""

from __future__ import annotations

import hashlib
import hmac
import mmap
import re
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

HOLD_S = 120.0  # s that a place is kept for a tab whose connection broke
SCARCE = 4  # one in so many places is left when the shares of addresses begin to count
SPARE = 8  # beside so many places one more is kept for tabs that come back
PRESENTERS = 32  # rows for those who present, who are never turned away
KEY, ADDRESS, SINCE, UNTIL = range(4)  # columns; times in ms on the clock of the machine
OPEN = 2**62  # in UNTIL, of a place whose tab is connected
NUMBER_BYTES, KEY_BYTES, SECRET_BYTES, SIGN_DIGITS = 8, 7, 32, 24
TICKET = re.compile(rf"([0-9a-f]{{{2 * KEY_BYTES}}})([0-9a-f]{{{SIGN_DIGITS}}})", re.ASCII)
PLACE_FIELD = "place"  # of an address: the ticket of a tab that comes back


@dataclass(frozen=True)
class Visitor:
    """Who asks for a place: from which address, with the key of the place that this tab had (0 for none), and whether it presents."""

    address: str = ""
    key: int = 0
    presents: bool = False


class Place(NamedTuple):
    """A place that was given out: its row, and its tab's key."""

    row: int
    key: int


class PlaceTable:
    """The places of `workers` processes, `most` for tabs of anybody; made before the processes part."""

    def __init__(self, workers: int, most: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.most, self.spare, self._clock = most, -(-most // SPARE), clock
        rows = most + self.spare + PRESENTERS
        memory = mmap.mmap(-1, workers * rows * (UNTIL + 1) * NUMBER_BYTES)
        self._rows = np.frombuffer(memory, dtype=np.int64).reshape(workers, rows, UNTIL + 1)
        self._secret = secrets.token_bytes(SECRET_BYTES)

    # --- tickets ---------------------------------------------------------------------------------------------------
    def draw_key(self) -> int:
        """The key of a tab that has none."""
        return int.from_bytes(secrets.token_bytes(KEY_BYTES)) or 1

    def ticket(self, key: int) -> str:
        """The word by which a tab shows that it had a place here."""
        digits = f"{key:0{2 * KEY_BYTES}x}"
        return digits + hmac.new(self._secret, digits.encode(), hashlib.sha256).hexdigest()[:SIGN_DIGITS]

    def key_of(self, ticket: str) -> int:
        """The key in a ticket of this server, 0 in any other word."""
        found = TICKET.fullmatch(ticket)
        return int(found[1], 16) if found and hmac.compare_digest(self.ticket(int(found[1], 16)), ticket) else 0

    # --- places ----------------------------------------------------------------------------------------------------
    def admits(self, visitor: Visitor) -> bool:
        """Whether there is a place for a visitor now."""
        if visitor.presents:
            return True
        taken = self._taken()
        if visitor.key and (taken[:, KEY] == visitor.key).any():  # the tab's own place, which may not know yet that it is gone
            return True
        count, most = len(np.unique(taken[:, KEY])), self.most + (self.spare if visitor.key else 0)
        left = most - count
        scarce = self.spare // 2 if visitor.key else self.most // SCARCE
        return left > scarce or (left > 0 and self._within_share(taken, visitor.address))

    def take(self, worker: int, visitor: Visitor) -> Place | None:
        """Give a place to a visitor; None where there is none. It is counted first and looked at then: of two that come at once to the
        last one both may be turned away, never both let in."""
        rows, now = self._rows[worker], self._now()
        free = np.flatnonzero(rows[:, UNTIL] <= now)
        if not len(free):
            return None
        place = Place(int(free[0]), visitor.key or self.draw_key())
        if not self.admits(visitor):
            return None
        if visitor.key:
            rows[(rows[:, KEY] == visitor.key) & (rows[:, UNTIL] < OPEN), UNTIL] = 0  # it was kept for this tab
        rows[place.row] = place.key, _number(visitor.address), now, OPEN
        if not (visitor.presents or visitor.key) and len(np.unique(self._taken()[:, KEY])) > self.most:
            rows[place.row, UNTIL] = 0
            return None
        return place

    def leave(self, worker: int, place: Place, broke: bool) -> None:
        """Give a place back; it is kept for a while where the connection `broke`."""
        self._rows[worker, place.row, UNTIL] = self._now() + int(1000 * HOLD_S) if broke else 0

    def overtaken(self, worker: int, place: Place) -> bool:
        """Whether the tab of a place has come back on another connection since."""
        mine, taken = self._rows[worker, place.row], self._taken()
        same = taken[(taken[:, KEY] == place.key) & (taken[:, UNTIL] == OPEN)]
        return bool((same[:, SINCE] > mine[SINCE]).any())

    def keep_for(self, worker: int) -> None:
        """A worker has ended and broken the connections of all its tabs: their places are kept for them."""
        rows = self._rows[worker]
        rows[rows[:, UNTIL] == OPEN, UNTIL] = self._now() + int(1000 * HOLD_S)

    @property
    def kept(self) -> int:
        """How many places are kept for tabs whose connections broke."""
        taken = self._taken()
        return len(np.setdiff1d(taken[taken[:, UNTIL] < OPEN, KEY], taken[taken[:, UNTIL] == OPEN, KEY]))

    def _within_share(self, taken: np.ndarray, address: str) -> bool:
        mine = _number(address)
        addresses = np.union1d(taken[:, ADDRESS], [mine])
        return len(np.unique(taken[taken[:, ADDRESS] == mine, KEY])) < self.most / max(len(addresses), 2)

    def _taken(self) -> np.ndarray:
        rows = self._rows.reshape(-1, UNTIL + 1)
        return rows[rows[:, UNTIL] > self._now()]

    def _now(self) -> int:
        return int(1000 * self._clock()) + 1  # a clock that begins at 0 has no free row then


def _number(address: str) -> int:
    """A number for an address; nothing of the address can be read from it."""
    return int.from_bytes(hashlib.blake2b(address.encode(), digest_size=KEY_BYTES).digest())
