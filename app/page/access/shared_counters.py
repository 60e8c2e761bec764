"""Count tabs and connections of all worker processes in shared memory.

Each row is written by its own worker alone, but for the beginning and the end of a process, which the parent writes.
"""

from __future__ import annotations

import mmap
import time
from dataclasses import dataclass

READY_FIELD, TABS_FIELD, ENDED_FIELD, SINCE_FIELD, STUCK_FIELD, HEARTBEAT_FIELD, STARTS_FIELD = range(7)  # numbers of a row
NUMBER_BYTES = 8  # of a number


@dataclass(frozen=True)
class WorkerFigures:
    """What is known of one worker: whether it `stands`, its open tabs, the connections it was handed that have `ended`, when its
    process began (on the clock of the machine), its threads that nothing can break off, when it last said that it lives, and how many
    processes it has had."""

    stands: bool
    tabs: int
    ended: int
    since: float
    stuck: int
    beat: float
    starts: int


class SharedCounters:
    """The figures of `workers` processes, numbered from 0; made before they part."""

    def __init__(self, workers: int = 1) -> None:
        self.workers, self.since = workers, time.monotonic()
        self._numbers = memoryview(mmap.mmap(-1, workers * (STARTS_FIELD + 1) * NUMBER_BYTES)).cast("d")

    def of(self, worker: int) -> WorkerFigures:
        """The figures of a worker now."""
        stands, tabs, ended, since, stuck, beat, starts = (self._numbers[self._at(worker, k)] for k in range(STARTS_FIELD + 1))
        return WorkerFigures(bool(stands), int(tabs), int(ended), since, int(stuck), beat, int(starts))

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
            self._numbers[self._at(worker, TABS_FIELD)] = self._numbers[self._at(worker, STUCK_FIELD)] = 0

    def enter(self, worker: int, most: int) -> bool:
        """Take a place for a tab; False where `most` of all workers together are taken.

        It is counted first and looked at then: of two that come at once to the last place both may be turned away, never both let in.
        """
        self._add(worker, TABS_FIELD, 1)
        if self.tabs <= most:
            return True
        self._add(worker, TABS_FIELD, -1)
        return False

    def leave(self, worker: int) -> None:
        """Give a place back."""
        self._add(worker, TABS_FIELD, -1)

    def note(self, worker: int, stuck: int) -> None:
        """How many threads of this worker go on although their tab was ended."""
        self._numbers[self._at(worker, STUCK_FIELD)] = stuck

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
        return worker * (STARTS_FIELD + 1) + which


@dataclass(frozen=True)
class WorkerSlot:
    """A worker's place at a tally, and the most tabs that all of them may have open together."""

    tally: SharedCounters
    worker: int
    most: int

    def enter(self) -> bool:
        """Take a place for a tab, if there is one."""
        return self.tally.enter(self.worker, self.most)

    def leave(self) -> None:
        """Give it back."""
        self.tally.leave(self.worker)

    def note(self, stuck: int) -> None:
        """How many threads go on although their tab was ended."""
        self.tally.note(self.worker, stuck)

    def beat(self) -> None:
        """This worker lives, and hears its browsers."""
        self.tally.beat(self.worker)

    @property
    def full(self) -> bool:
        """Whether all places are taken."""
        return self.tally.tabs >= self.most

    def health(self) -> dict[str, object]:
        """The sum over all workers and, where there are several, the figures of each; nothing of any person."""
        now = time.monotonic()
        each = [self.tally.of(worker) for worker in range(self.tally.workers)]
        health: dict[str, object] = {"tabs": sum(row.tabs for row in each), "most_tabs": self.most,
                                     "stuck": sum(row.stuck for row in each), "seconds": round(now - self.tally.since, 1)}
        if len(each) > 1:
            health["workers"] = [{"worker": k, "stands": row.stands, "tabs": row.tabs, "stuck": row.stuck,
                                  "seconds": round(now - row.since, 1), "starts": row.starts} for k, row in enumerate(each, 1)]
        return health
