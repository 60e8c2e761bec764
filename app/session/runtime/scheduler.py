"""Run one tab worker at a time; user input first.

The interpreter runs one thread at a time whatever is done. Where forty tabs ask for it at once, the thread that talks to all
browsers waits behind each of them; where they queue here instead, it waits behind one.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

MAX_TURN_S = 0.1  # s of a turn: whoever works longer than that goes on, and the next one begins beside it
BACKGROUND_SHARE_S = 0.006  # s that each turn of a hand leaves to what nobody has asked for; a longer turn is paid back by the next ones
MOST_OWED_S = 0.05  # s that either rank can save up or owe


class Ticket:
    """A place in the queue; its lock is let go when the turn has come."""

    def __init__(self, hand: bool) -> None:
        self.hand = hand
        self.called = threading.Lock()
        self.called.acquire()


class Scheduler:
    """A queue of two ranks: a hand that waits comes before what nobody has asked for, each rank in its order."""

    def __init__(self, lease: float = MAX_TURN_S, clock: Callable[[], float] = time.monotonic) -> None:
        self._lease, self._clock = lease, clock
        self._lock = threading.Lock()
        self._hands, self._others = deque[Ticket](), deque[Ticket]()
        self._holder: Ticket | None = None
        self._since, self._owed = 0.0, 0.0  # since when the turn is held; s that hands owe to the others, negative where these owe

    @contextmanager
    def turn(self, hand: bool) -> Iterator[float]:
        """Wait until it is one's turn, the seconds that took; it ends with the block, or with its lease if somebody waits then."""
        ticket, began = Ticket(hand), self._clock()
        with self._lock:
            (self._hands if hand else self._others).append(ticket)
            self._call()
        while not ticket.called.acquire(timeout=self._lease):
            with self._lock:
                self._call()
        try:
            yield self._clock() - began
        finally:
            with self._lock:
                if self._holder is ticket:
                    self._end()
                    self._call()

    @property
    def waiting(self) -> int:
        """How many wait."""
        return len(self._hands) + len(self._others)

    def _call(self) -> None:
        """Call the next one, if the turn is free or has lasted its time."""
        if self._holder is not None:
            if self._clock() - self._since < self._lease:
                return
            self._end()
        if not self._hands and not self._others:
            return
        hand = bool(self._hands) and (self._owed <= 0 or not self._others)
        self._holder, self._since = (self._hands if hand else self._others).popleft(), self._clock()
        self._holder.called.release()

    def _end(self) -> None:
        """The turn is free; what it took from those of the other rank who waited is written down."""
        if self._holder is not None:
            if self._holder.hand and self._others:
                self._owed = min(self._owed + BACKGROUND_SHARE_S, MOST_OWED_S)
            elif not self._holder.hand and self._hands:
                self._owed = max(self._owed + self._since - self._clock(), -MOST_OWED_S)
        self._holder = None
