"""Run a tab's thread: queue its commands, step until the queue is closed, survive any failing step."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterator

from ..commands.commands import Command, Edit, SetKnobs

log = logging.getLogger(__name__)

PAUSE_S, MAX_PAUSE_S = 0.05, 1.0  # s after a step that failed; more after several in a row, at most MAX_PAUSE_S
RETRY_S, MAX_RETRY_S = 1.0, 30.0  # the same after a beginning that failed


def start_worker(mailbox: Mailbox, begin: Callable[[], None], step: Callable[[], None],
                 failed: Callable[[], None]) -> None:
    """Run `work` on a thread of its own, which does not keep the process alive."""
    threading.Thread(target=work, args=(mailbox, begin, step, failed), name="observer-lab session", daemon=True).start()


def work(mailbox: Mailbox, begin: Callable[[], None], step: Callable[[], None], failed: Callable[[], None]) -> None:
    """Begin, then step until the mailbox is closed. Where a step fails, `failed` is called and the next comes a little
    later; where the beginning fails, as on a machine that is too busy, it is tried again."""
    failures = 0
    while not mailbox.closed:
        try:
            begin()
            break
        except BaseException:
            if mailbox.closed:
                return
            failures += 1
            log.exception("a session could not be opened; it is tried again")
            mailbox.wait_for_end(min(RETRY_S * failures, MAX_RETRY_S))
    failures = 0
    while not mailbox.closed:
        try:
            step()
            failures = 0
        except BaseException:
            if mailbox.closed:
                return
            failures += 1
            log.exception("a step of a session failed")
            failed()
            time.sleep(min(PAUSE_S * failures, MAX_PAUSE_S))


class Mailbox:
    """Edits in order, numbered: the latest change of the same knobs replaces an older one, commands stay."""

    def __init__(self) -> None:
        self._edits: list[tuple[int, Edit]] = []
        self._count = 0
        self._ready = threading.Condition()
        self._mirrored: set[int] = set()
        self.closed = False

    def post(self, edit: Edit, mirrored: bool = False) -> int:
        """Put an edit in and give its number; cheap enough for the event loop. A closed box takes nothing.

        What is `mirrored` was done by a hand on another page, and is not told to that one again.
        """
        with self._ready:
            if self.closed:
                return self._count
            if isinstance(edit, SetKnobs):
                self._remove_older(edit)
            self._count += 1
            self._edits.append((self._count, edit))
            if mirrored:
                self._mirrored.add(self._count)
            self._ready.notify()
            return self._count

    def _remove_older(self, edit: SetKnobs) -> None:
        """Forget a waiting change of just the same knobs, if no command came after it."""
        for i in range(len(self._edits) - 1, -1, -1):
            waiting = self._edits[i][1]
            if not isinstance(waiting, SetKnobs):
                return
            if waiting.values.keys() == edit.values.keys():
                del self._edits[i]
                return

    def take(self, wait: float | None) -> list[tuple[int, Edit]]:
        """All edits with their numbers; waits at most `wait` seconds for the first (None: until one comes or the box is
        closed)."""
        with self._ready:
            if not self._edits and not self.closed and (wait is None or wait > 0):
                self._ready.wait(wait)
            edits, self._edits = self._edits, []
            return edits

    def wait_for_end(self, most: float) -> None:
        """Wait until the box is closed, at most so many seconds; edits wait with it."""
        with self._ready:
            self._ready.wait_for(lambda: self.closed, most)

    def was_mirrored(self, number: int) -> bool:
        """Whether an edit came from another page; asked once."""
        with self._ready:
            found = number in self._mirrored
            self._mirrored.discard(number)
            return found

    def empty(self) -> bool:
        """Whether nothing waits."""
        return not self._edits

    def close(self) -> None:
        """Wake the worker up to end."""
        with self._ready:
            self.closed = True
            self._ready.notify()


def grouped(edits: list[tuple[int, Edit]]) -> Iterator[tuple[int, list[SetKnobs] | Command]]:
    """Neighbouring knob changes together, commands one by one, all in order; each with the number of its last edit."""
    waiting: list[SetKnobs] = []
    last = 0
    for number, edit in edits:
        if isinstance(edit, SetKnobs):
            waiting.append(edit)
            last = number
            continue
        if waiting:
            yield last, waiting
            waiting = []
        yield number, edit
    if waiting:
        yield last, waiting
