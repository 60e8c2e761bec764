"""Run slow jobs beside the tab's worker, so that no input waits."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from ..commands.commands import Edit

MAX_QUEUED_JOBS = 8  # jobs of a tab that wait at once


class BackgroundJobs:
    """One thread a tab, while there is something to do; what a job returns is posted like any other edit."""

    def __init__(self, post: Callable[[Edit], object]) -> None:
        self._post = post
        self._waiting: deque[Callable[[], Edit]] = deque()
        self._lock = threading.Lock()
        self._busy = self._left = False

    def send(self, job: Callable[[], Edit]) -> bool:
        """Have it done after those that wait; False if too many do. A job must not raise."""
        with self._lock:
            if len(self._waiting) >= MAX_QUEUED_JOBS:
                return False
            self._waiting.append(job)
            idle, self._busy = not self._busy, True
        if idle:
            threading.Thread(target=self._work, name="observer-lab job", daemon=True).start()
        return True

    def tell(self, notice: Edit) -> bool:
        """Post a word of a job that goes on; False if nobody waits any more."""
        with self._lock:
            if self._left:
                return False
        self._post(notice)
        return True

    def forget(self) -> None:
        """Nobody waits any more."""
        with self._lock:
            self._left = True
            self._waiting.clear()

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._busy = False
                    return
                job = self._waiting.popleft()
            self._post(job())
