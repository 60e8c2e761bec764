"""Run a tab's thread: step until its mailbox is closed, and survive any failing step."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from .mailbox import Mailbox

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
