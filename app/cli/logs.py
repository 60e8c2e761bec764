"""Set up the log of the server: terminal or rotating file, each kind of line at a bounded rate."""

from __future__ import annotations

import json
import logging
import logging.handlers
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from .options import error_cause

LOG_NAME, MAX_LOG_BYTES, LOG_FILES = "observer-lab.log", 1_000_000, 5  # bytes of a file, and files
LOG_FORMAT = "%(asctime)s %(levelname)s %(name)s: %(message)s"
LINES_AT_ONCE, SECONDS_PER_LINE = 20.0, 30.0  # of one kind: so many at once, then one more every so many seconds
MAX_KINDS = 1000  # kinds that are remembered


class OneLineOfJson(logging.Formatter):
    """A record as one line: time in UTC, level, the worker if there are several, where, what, and the traceback if there is one."""

    converter = staticmethod(time.gmtime)

    def __init__(self, worker: int = 0) -> None:
        super().__init__()
        self._worker = {"worker": worker} if worker else {}

    def format(self, record: logging.LogRecord) -> str:
        """The line."""
        line = {"time": self.formatTime(record, "%Y-%m-%dT%H:%M:%SZ"), "level": record.levelname.lower(),
                **self._worker, "where": record.name, "what": record.getMessage()}
        if record.exc_info:
            line["trace"] = self.formatException(record.exc_info)
        return writable(json.dumps(line, ensure_ascii=False))


class RotatingFile(logging.handlers.RotatingFileHandler):
    """A file that rotates. Where it cannot be written, as on a full disk, one sentence says so, and it goes on when it can."""

    _told = False

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record down, if that is possible."""
        self._failed = False
        super().emit(record)
        self._told = self._failed

    def handleError(self, record: logging.LogRecord) -> None:
        """Say once that nothing is written down any more."""
        self._failed = True
        if not self._told and sys.stderr is not None:
            with suppress(OSError, ValueError):  # stderr may be a file on the same disk
                print(f"observer-lab: {LOG_NAME} cannot be written ({error_cause(sys.exc_info()[1])}); the server goes on without it.",
                      file=sys.stderr, flush=True)


def set_up(as_json: bool, folder: str | None, worker: int = 0) -> None:
    """Write warnings, and what the command itself says, to stderr and to a file in `folder`: FILE or, for a worker of that number, one
    of its own, because two processes cannot rotate one file. Raises OSError where that fails."""
    handlers: list[logging.Handler] = [logging.StreamHandler()]
    if folder is not None:
        Path(folder).mkdir(parents=True, exist_ok=True)
        name = LOG_NAME.replace(".", f"-{worker}.") if worker else LOG_NAME
        handlers.append(RotatingFile(Path(folder) / name, maxBytes=MAX_LOG_BYTES, backupCount=LOG_FILES, encoding="utf-8"))
    plain = LOG_FORMAT.replace(" %(name)s", f" worker {worker} %(name)s") if worker else LOG_FORMAT
    limit = RateLimit()
    for handler in handlers:
        handler.setFormatter(OneLineOfJson(worker) if as_json else OneLine(plain))
        handler.addFilter(limit)
    logging.basicConfig(level=logging.WARNING, handlers=handlers, force=True)
    logging.getLogger("observer_lab.cli").setLevel(logging.INFO)
    log_uncaught_errors(logging.getLogger("observer_lab.cli"))


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
