"""Keep what a stranger's connection causes to one line of the log."""

from __future__ import annotations

import logging


class OneLineFilter(logging.Filter):
    """What a stranger sent costs one line in the log: no traceback, and nothing for a handshake that was none."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the record is written down."""
        if record.getMessage() == "opening handshake failed":
            return False
        if record.exc_info and record.exc_info[1] is not None:
            record.msg, record.args = f"{record.getMessage()} ({type(record.exc_info[1]).__name__})", ()
            record.exc_info = None
        return True
