"""Set up the log of the server: terminal, and a rotating file where a folder is given."""

from __future__ import annotations

import json
import logging
import logging.handlers
import sys
import time
from contextlib import suppress
from pathlib import Path

from .log_limits import OneLine, RateLimit, log_uncaught_errors, writable
from .options import error_cause

LOG_NAME, MAX_LOG_BYTES, LOG_FILES = "observer-lab.log", 1_000_000, 5  # bytes of a file, and files
LOG_FORMAT = "%(asctime)s %(levelname)s %(name)s: %(message)s"


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
