"""Count tabs and connections of all worker processes in shared memory.

Each row is written by its own worker alone, but for the beginning and the end of a process, which the parent writes.
"""

from __future__ import annotations

import mmap
import time
from dataclasses import dataclass

from .places import Place, PlaceTable, Visitor

# numbers of a row
READY_FIELD, TABS_FIELD, ENDED_FIELD, SINCE_FIELD, STUCK_FIELD, HEARTBEAT_FIELD, STARTS_FIELD, RESIDENT_FIELD, LAG_FIELD = range(9)
NUMBER_BYTES = 8  # of a number
ANYBODY = Visitor()


@dataclass(frozen=True)
class WorkerFigures:
    """What is known of one worker: whether it `stands`, its open tabs, the connections it was handed that have `ended`, when its
    process began (on the clock of the machine), its threads that nothing can break off, when it last said that it lives, how many
    processes it has had, the bytes of its memory, and the seconds that its event loop took to answer."""

    stands: bool
    tabs: int
    ended: int
    since: float
    stuck: int
    beat: float
    starts: int
    resident: int = 0
    lag: float = 0.0


class SharedCounters:
    """The figures of `workers` processes, numbered from 0; made before they part."""

    def __init__(self, workers: int = 1, most: int = 200) -> None:
        self.workers, self.since, self.places = workers, time.monotonic(), PlaceTable(workers, most)
        self._numbers = memoryview(mmap.mmap(-1, workers * (LAG_FIELD + 1) * NUMBER_BYTES)).cast("d")

    def of(self, worker: int) -> WorkerFigures:
        """The figures of a worker now."""
        stands, tabs, ended, since, stuck, beat, starts, resident, lag = (self._numbers[self._at(worker, k)] for k in range(LAG_FIELD + 1))
        return WorkerFigures(bool(stands), int(tabs), int(ended), since, int(stuck), beat, int(starts), int(resident), lag)

    @property
    def tabs(self) -> int:
        """The tabs that are open, of all workers."""
        return sum(self.of(worker).tabs for worker in range(self.workers))

    def begin(self, worker: int) -> None:
        """A process of this worker begins: it has nothing yet, whatever the one before it had."""
        starts, now = self.of(worker).starts + 1, time.monotonic()
        for k, number in (
            (READY_FIELD, 0),
            (TABS_FIELD, 0),
            (ENDED_FIELD, 0),
            (SINCE_FIELD, now),
            (STUCK_FIELD, 0),
            (HEARTBEAT_FIELD, now),
            (STARTS_FIELD, starts),
        ):
            self._numbers[self._at(worker, k)] = number

    def stand(self, worker: int, stands: bool) -> None:
        """It takes connections, or has ended and left all its tabs."""
        self._numbers[self._at(worker, READY_FIELD)] = stands
        if not stands:
            self.places.keep_for(worker)
            self._numbers[self._at(worker, TABS_FIELD)] = self._numbers[self._at(worker, STUCK_FIELD)] = 0

    def enter(self, worker: int, visitor: Visitor) -> Place | None:
        """Take a place for a tab; None where there is none for this visitor."""
        place = self.places.take(worker, visitor)
        if place is not None:
            self._add(worker, TABS_FIELD, 1)
        return place

    def leave(self, worker: int, place: Place, broke: bool = False) -> None:
        """Give a place back; it is kept for a while where the connection `broke`."""
        self.places.leave(worker, place, broke)
        self._add(worker, TABS_FIELD, -1)

    def note(self, worker: int, stuck: int, resident: int = 0, lag: float = 0.0) -> None:
        """How many threads of this worker go on although their tab was ended, its memory in bytes, and how late its loop answers."""
        for field, number in ((STUCK_FIELD, stuck), (RESIDENT_FIELD, resident), (LAG_FIELD, lag)):
            self._numbers[self._at(worker, field)] = number

    def beat(self, worker: int) -> None:
        """It lives, and hears its browsers."""
        self._numbers[self._at(worker, HEARTBEAT_FIELD)] = time.monotonic()

    def count_ended_connection(self, worker: int) -> None:
        """A connection that was handed to this worker is over."""
        self._add(worker, ENDED_FIELD, 1)

    def _add(self, worker: int, which: int, number: int) -> None:
        self._numbers[self._at(worker, which)] += number

    @staticmethod
    def _at(worker: int, which: int) -> int:
        return worker * (LAG_FIELD + 1) + which


@dataclass(frozen=True)
class WorkerSlot:
    """A worker's part of a tally."""

    tally: SharedCounters
    worker: int

    @property
    def most(self) -> int:
        """The most tabs of anybody that all workers have open together."""
        return self.tally.places.most

    def enter(self, visitor: Visitor = ANYBODY) -> Place | None:
        """Take a place for a tab, if there is one."""
        return self.tally.enter(self.worker, visitor)

    def leave(self, place: Place, broke: bool = False) -> None:
        """Give it back."""
        self.tally.leave(self.worker, place, broke)

    def overtaken(self, place: Place) -> bool:
        """Whether its tab has come back on another connection."""
        return self.tally.places.overtaken(self.worker, place)

    def full(self, visitor: Visitor = ANYBODY) -> bool:
        """Whether there is no place for a visitor."""
        return not self.tally.places.admits(visitor)

    def note(self, stuck: int, resident: int = 0, lag: float = 0.0) -> None:
        """How many threads go on although their tab was ended, the memory in bytes, and how late the loop answers."""
        self.tally.note(self.worker, stuck, resident, lag)

    def beat(self) -> None:
        """This worker lives, and hears its browsers."""
        self.tally.beat(self.worker)

    def health(self) -> dict[str, object]:
        """The sum over all workers and, where there are several, the figures of each; nothing of any person."""
        now = time.monotonic()
        each = [self.tally.of(worker) for worker in range(self.tally.workers)]
        health: dict[str, object] = {"tabs": sum(row.tabs for row in each), "most_tabs": self.most, "kept_places": self.tally.places.kept,
                                     "stuck": sum(row.stuck for row in each), "seconds": round(now - self.tally.since, 1),
                                     "resident_bytes": sum(row.resident for row in each), "lag_s": round(max(row.lag for row in each), 4)}
        if len(each) > 1:
            health["workers"] = [{"worker": k, "stands": row.stands, "tabs": row.tabs, "stuck": row.stuck,
                                  "seconds": round(now - row.since, 1), "starts": row.starts,
                                  "resident_bytes": row.resident, "lag_s": round(row.lag, 4)} for k, row in enumerate(each, 1)]
        return health
