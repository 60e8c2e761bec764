"""Write votes down, many in one transaction, before any of them is acknowledged."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable

from .kept_room import KeptRoom
from .votes import Answer

MAX_BATCH = 1000  # votes of one transaction

log = logging.getLogger(__name__)
Cast = tuple[int, str, Answer, Callable[[bool], object]]  # vote, ballot, answer, who is told


class VoteWriter:
    """A thread that writes what waits. What it cannot write is told as not counted."""

    def __init__(self, store: KeptRoom) -> None:
        self._store, self.failing = store, False  # whether the last votes could not be written down
        self._waiting: queue.SimpleQueue[Cast | None] = queue.SimpleQueue()

    def start(self) -> None:
        """Begin the thread."""
        threading.Thread(target=self._run, name="observer-lab votes", daemon=True).start()

    def close(self) -> None:
        """End it after what waits."""
        self._waiting.put(None)

    def cast(self, vote: int, ballot: str, answer: Answer, told: Callable[[bool], object]) -> None:
        """Take a vote; `told` is called on the writer's thread once it is on the disk, with whether it counts."""
        self._waiting.put((vote, ballot, answer, told))

    def _run(self) -> None:
        while True:
            batch = [self._waiting.get()]
            while len(batch) < MAX_BATCH and not self._waiting.empty():
                batch.append(self._waiting.get())
            votes = [each for each in batch if each is not None]
            try:
                counted = self._store.cast([each[:3] for each in votes])
                self.failing = False
            except Exception:
                self.failing = True
                log.exception("votes could not be written down")
                counted = [False] * len(votes)
            for (*_, told), counts in zip(votes, counted, strict=True):
                told(counts)
            if None in batch:
                return
