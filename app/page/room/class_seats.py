"""Give each follower of one worker a number, and show it the run of that number."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from functools import partial

from ...classroom.class_runs import ClassRuns, read_runs
from ...classroom.kept_room import KeptRoom
from .follower import Follower
from .own_run import own_run_html


class ClassSeats:
    """The numbers of this worker's followers. Only the thread that counts the room calls `update`."""

    def __init__(self, store: KeptRoom, worker: int) -> None:
        self._store, self._worker = store, worker
        self._seats: dict[int, int] = {}
        self._shown = -1
        store.empty_worker(worker)

    def update(self, followers: Mapping[int, Follower], loop: asyncio.AbstractEventLoop) -> None:
        """Number those who have come, forget those who have left, and show what runs there are now."""
        here = dict(followers)
        left = [client for client in self._seats if client not in here]
        new = [client for client in here if client not in self._seats]
        if left:
            self._store.leave_seats([self._seats.pop(client) for client in left])
        if new:
            self._seats.update(zip(new, self._store.take_seats(self._worker, len(new)), strict=True))
        number = self._store.run_number
        if number != self._shown:
            self._shown = number
            words = self._store.runs()
            self._show(here, None if not words else read_runs(words), loop)

    def _show(self, followers: Mapping[int, Follower], runs: ClassRuns | None, loop: asyncio.AbstractEventLoop) -> None:
        for client, follower in followers.items():
            own = None if runs is None else runs.runs.get(self._seats[client])
            content = "" if runs is None or own is None else own_run_html(runs, own, follower.language)
            if loop.is_closed():  # the server ends
                return
            loop.call_soon_threadsafe(partial(follower.show_run, content))
