"""Hand accepted connections from one process to another over a Unix socket."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Callable
from typing import Any

log = logging.getLogger(__name__)

CONNECTION_TAG = b"c"  # what goes with a connection, because nothing cannot be sent
READY = b"r"  # what a worker says once it takes connections


def can_send_connections() -> bool:
    """Whether this operating system can hand a connection to another process."""
    return hasattr(socket, "send_fds") and hasattr(socket, "AF_UNIX")


def send_connection(channel: socket.socket, connection: socket.socket) -> bool:
    """Give a connection to whoever listens at the other end; False where it cannot take one now."""
    try:
        socket.send_fds(channel, [CONNECTION_TAG], [connection.fileno()])
    except OSError:
        return False
    return True


class HandedSocket(socket.socket):
    """A connection that was handed over; `over` is called once, when it is closed."""

    def __init__(self, number: int, over: Callable[[], object]) -> None:
        super().__init__(fileno=number)
        self._over: Callable[[], object] | None = over

    def close(self) -> None:
        """Close it, and say so."""
        super().close()
        over, self._over = self._over, None
        if over is not None:
            over()


class HandedListener(socket.socket):
    """A listening socket to all who use it, which takes connections from the other end of a Unix socket.

    `address` is that of the port that they come from; `over` is called when one of them is over, `gone` when no more will come,
    because the other end has gone.
    """

    def __init__(self, channel: socket.socket, address: Any, over: Callable[[], object], gone: Callable[[], object]) -> None:
        super().__init__(fileno=channel.detach())
        self._address, self._over, self._gone = address, over, gone
        self.setblocking(False)

    def listen(self, backlog: int = 0, /) -> None:
        """Nothing: the process that hands them over listens."""

    def getsockname(self) -> Any:
        """The address of the port."""
        return self._address

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection and who it is from. Raises BlockingIOError where none waits, as every listener does."""
        try:
            said, numbers, _, _ = socket.recv_fds(self, len(CONNECTION_TAG), 1)
        except BlockingIOError:
            raise
        except OSError:
            said, numbers = b"", []
        if not said:
            asyncio.get_running_loop().remove_reader(self.fileno())
            self._gone()
            raise BlockingIOError
        if not numbers:  # this process has too many files open, and the connection is lost
            log.warning("a connection was lost: too many files are open")
            self._over()
            raise ConnectionAbortedError
        connection = HandedSocket(numbers[0], self._over)
        try:
            return connection, connection.getpeername()
        except OSError as left:
            connection.close()
            raise ConnectionAbortedError from left
