"""Write each kind of line to the log at a bounded rate, and everything on one line."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

LINES_AT_ONCE, SECONDS_PER_LINE = 20.0, 30.0  # of one kind: so many at once, then one more every so many seconds
MAX_KINDS = 1000  # kinds that are remembered


@dataclass
class LineAllowance:
    """How many lines of one kind may still be written, since when, and how many were left out."""

    left: float
    since: float
    left_out: int = 0


class RateLimit(logging.Filter):
    """Lets a kind of line (its logger, its level, its words without the values) pass at a bounded rate.

    The line that passes after others were left out says how many. All handlers share one filter, which decides once for each record.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._kinds: dict[tuple[str, int, str], LineAllowance] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the record is written."""
        decided = getattr(record, "within_rate", None)
        if decided is None:
            decided = record.within_rate = record.levelno <= logging.INFO or self._passes(record)
        return decided

    def _passes(self, record: logging.LogRecord) -> bool:
        now = self._clock()
        if len(self._kinds) >= MAX_KINDS:
            self._kinds.clear()
        kind = self._kinds.setdefault((record.name, record.levelno, str(record.msg)), LineAllowance(LINES_AT_ONCE, now))
        kind.left = min(LINES_AT_ONCE, kind.left + (now - kind.since) / SECONDS_PER_LINE)
        kind.since = now
        if kind.left < 1.0:
            kind.left_out += 1
            return False
        kind.left -= 1.0
        if kind.left_out:
            record.msg, record.args = f"{record.getMessage()} (and {kind.left_out} more like it)", ()
            kind.left_out = 0
        return True


class OneLine(logging.Formatter):
    """A record as one line of text, with its traceback if there is one; no value in it can begin a line of its own."""

    def format(self, record: logging.LogRecord) -> str:
        """The line."""
        return writable(" | ".join(super().format(record).splitlines()))


def writable(words: str) -> str:
    """Words that any file can hold: what UTF-8 cannot is written as an escape."""
    return words.encode("utf-8", "backslashreplace").decode("utf-8")


def log_uncaught_errors(log: logging.Logger) -> None:
    """Send warnings of Python and errors that end a thread to the log."""
    logging.captureWarnings(True)

    def tell(what: threading.ExceptHookArgs) -> None:
        if what.exc_value is not None and what.exc_type is not SystemExit:
            log.error("a thread ended by an error", exc_info=(what.exc_type, what.exc_value, what.exc_traceback))
    threading.excepthook = tell
