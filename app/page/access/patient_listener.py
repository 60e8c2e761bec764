"""A listening socket that turns connections away while too many files are open."""

from __future__ import annotations

import errno
import logging
import os
import socket
from typing import Any

OUT_OF_FILES = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})

log = logging.getLogger(__name__)


class PatientListener(socket.socket):
    """A listener that keeps one file in reserve. When no other is left, it accepts with that one, and closes the connection.

    asyncio itself reports an error for every place of the queue of a listener that cannot accept, a hundred at a time.
    """

    def __init__(self, fileno: int) -> None:
        super().__init__(fileno=fileno)
        self._reserve: int | None = os.open(os.devnull, os.O_RDONLY)

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection and who it is from. Raises ConnectionAbortedError where one was turned away."""
        try:
            return super().accept()
        except OSError as problem:
            if problem.errno not in OUT_OF_FILES:
                raise
            if self._reserve is None:
                raise
            self._turn_away(self._reserve)
            raise ConnectionAbortedError from problem

    def close(self) -> None:
        """Close it, and the file in reserve."""
        super().close()
        reserve, self._reserve = self._reserve, None
        if reserve is not None:
            os.close(reserve)

    def _turn_away(self, reserve: int) -> None:
        log.warning("a connection was turned away: too many files are open")
        os.close(reserve)
        self._reserve = None
        try:
            super().accept()[0].close()
            self._reserve = os.open(os.devnull, os.O_RDONLY)
        except OSError:  # another thread took the file; the connection waits
            return
