"""Send the shared pages to the followers of one worker, each packed batch as it is."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import deque
from collections.abc import Callable
from typing import Protocol

from ...classroom.kept_room import KeptPages
from ...classroom.page_store import StandingPage

POLL_S = 0.03  # s between two looks at what another worker has written
KEPT_BATCHES = 300  # batches that a slow follower may be behind
RESTART = 1012  # the code of a close after which a page comes back by itself

log = logging.getLogger(__name__)


class FollowerConnection(Protocol):
    """A connection, as far as a relay uses it."""

    async def send(self, message: bytes) -> None:
        """Send a batch."""

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """End it; its page comes back."""

    def touch(self) -> None:
        """Its page is used."""


class Feed:
    """The batches of one kind of page as far as this worker has read them. All but `read` runs on the event loop."""

    def __init__(self, kind: str, standing: StandingPage | None) -> None:
        self.kind, self.standing = kind, standing
        self.series = -1 if standing is None else standing.series
        self.last = -1 if standing is None else standing.batch
        self._kept: deque[tuple[int, bytes]] = deque(maxlen=KEPT_BATCHES)
        self._news = asyncio.Event()

    def publish(self, standing: StandingPage | None, batches: list[tuple[int, bytes]]) -> None:
        """Batches have come, or another series has begun with a standing page."""
        if standing is not None and standing.series != self.series:
            self.series, self.last = standing.series, standing.batch
            self._kept.clear()
        self.standing = standing or self.standing
        for number, data in batches:
            if number > self.last:
                self._kept.append((number, data))
                self.last = number
        news, self._news = self._news, asyncio.Event()
        news.set()

    def after(self, series: int, batch: int) -> list[tuple[int, bytes]] | None:
        """What a follower lacks; None where its page cannot be brought up to date by batches."""
        if series != self.series or (self._kept and batch < self._kept[0][0] - 1) or (not self._kept and batch < self.last):
            return None
        return [(number, data) for number, data in self._kept if number > batch]

    async def wait(self) -> None:
        """Until there is more."""
        await self._news.wait()


class Relay:
    """Reads what the room's page store gets and hands it to this worker's followers."""

    def __init__(self, store: KeptPages, loop: asyncio.AbstractEventLoop, poll: float = POLL_S) -> None:
        self._store, self._loop, self._poll = store, loop, poll
        self._feeds: dict[str, Feed] = {}
        self._wake, self._closed = threading.Event(), False

    def start(self) -> None:
        """Begin reading."""
        threading.Thread(target=self._run, name="observer-lab relay", daemon=True).start()

    def close(self) -> None:
        """End reading."""
        self._closed = True
        self._wake.set()

    def wake(self) -> None:
        """This worker's own presenter has written something."""
        self._wake.set()

    async def follow(self, kind: str, connection: FollowerConnection, began: Callable[[], object]) -> None:
        """Send a page of this kind for as long as the connection lives; `began` is called before its first batch."""
        feed = self._feeds.get(kind)
        if feed is None:
            feed = self._feeds.setdefault(kind, Feed(kind, await asyncio.to_thread(self._store.standing, kind)))
            self._wake.set()
        while feed.standing is None:
            await feed.wait()
        standing = await asyncio.to_thread(self._store.standing, kind)
        assert standing is not None
        while feed.series < standing.series:  # another page leads, and this worker has read none of its batches yet
            await feed.wait()
        began()
        await connection.send(standing.data)
        series, batch = standing.series, standing.batch
        while (lacking := feed.after(series, batch)) is not None:
            for number, data in lacking:
                await connection.send(data)
                connection.touch()
                batch = number
            if not lacking:
                await feed.wait()
        await connection.close(RESTART, "The lecture goes on elsewhere.")

    def _run(self) -> None:
        while not self._closed:
            self._wake.wait(self._poll)
            self._wake.clear()
            for feed in list(self._feeds.values()):
                try:
                    self._read(feed)
                except Exception:
                    log.exception("the page of the room could not be read")

    def _read(self, feed: Feed) -> None:
        standing = None
        if feed.standing is None or self._store.series != feed.series:
            standing = self._store.standing(feed.kind)
            if standing is None or (standing.series == feed.series and feed.standing is not None):
                return
        series, last = (feed.series, feed.last) if standing is None else (standing.series, standing.batch)
        batches = self._store.after(feed.kind, series, last)
        if (standing is not None or batches) and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(feed.publish, standing, batches)
