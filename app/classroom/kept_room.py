"""Say what a store of a room keeps, open the one at a place, and write votes down many at a time."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Protocol

from .page_store import PageStore, StandingPage
from .room_store import RoomStore
from .votes import Answer, Asked, Vote

Place = Path | str  # a folder, or the address of a Redis server
REDIS = ("redis://", "rediss://")  # how such an address begins; the second is over TLS
MAX_BATCH = 1000  # votes of one transaction

log = logging.getLogger(__name__)
Cast = tuple[int, str, Answer, Callable[[bool], object]]  # vote, ballot, answer, who is told


class KeptRoom(Protocol):
    """What a room's votes and counts are kept in, for all its workers. `RoomStore` says what each method does."""

    def close(self) -> None: ...
    @property
    def secret(self) -> str: ...
    @property
    def state(self) -> str: ...
    def keep_state(self, token: str) -> None: ...
    @property
    def paused(self) -> bool: ...
    def pause(self, on: bool) -> None: ...
    def open_vote(self, lesson: str, scene: str, options: int, asked: Asked | None = None) -> None: ...
    def close_vote(self) -> None: ...
    def mark_vote(self, vote: Vote) -> None: ...
    def cast(self, ballots: Iterable[tuple[int, str, Answer]]) -> list[bool]: ...
    def votes(self) -> tuple[Vote, ...]: ...
    def report(self, worker: int, people: Mapping[str, int], slower: int) -> None: ...
    def seen(self) -> dict[str, int]: ...
    def presence(self) -> tuple[dict[str, int], int]: ...
    def forget_presence(self) -> None: ...
    @property
    def hands(self) -> int: ...
    def lower_hands(self) -> None: ...
    @property
    def seed(self) -> int: ...
    def take_seats(self, worker: int, count: int) -> list[int]: ...
    def leave_seats(self, seats: Iterable[int]) -> None: ...
    def empty_worker(self, worker: int) -> None: ...
    def seats(self) -> tuple[int, ...]: ...
    def keep_runs(self, words: str) -> None: ...
    @property
    def run_number(self) -> int: ...
    def runs(self) -> str: ...


class KeptPages(Protocol):
    """What the packed pages of a room are kept in. `PageStore` says what each method does."""

    def close(self) -> None: ...
    @property
    def series(self) -> int: ...
    def begin_series(self) -> int: ...
    def want(self, page: str) -> None: ...
    def wanted(self) -> list[str]: ...
    def append(self, page: str, series: int, batch: int, data: bytes) -> None: ...
    def stand(self, page: str, series: int, batch: int, data: bytes) -> None: ...
    def standing(self, page: str) -> StandingPage | None: ...
    def after(self, page: str, series: int, batch: int) -> list[tuple[int, bytes]]: ...
    def keep_lead(self, seconds: float) -> None: ...
    def end_lead(self) -> None: ...
    def is_led(self) -> bool: ...
    def add_act(self, words: str) -> None: ...
    def last_act(self) -> str: ...
    def acts_after(self, mark: str) -> list[tuple[str, str]]: ...


def is_redis(place: Place) -> bool:
    """Whether a place is the address of a Redis server."""
    return isinstance(place, str) and place.startswith(REDIS)


def open_room(place: Place) -> KeptRoom:
    """The room at a place. Raises RoomProblem, and for a folder sqlite3.Error or OSError."""
    if is_redis(place):
        from .redis_room import RedisRoom

        return RedisRoom(str(place))
    return RoomStore(Path(place))


def open_pages(place: Place) -> KeptPages:
    """The pages of the room at a place. Raises likewise."""
    if is_redis(place):
        from .redis_pages import RedisPages

        return RedisPages(str(place))
    return PageStore(Path(place))


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
