"""Remember that somebody has asked a server for its end."""

from __future__ import annotations

import signal
import sys

ENDINGS = (signal.SIGINT, signal.SIGTERM)


class Ending:
    """Whether somebody has asked for the end, by Ctrl-C or SIGTERM.

    Before all stands that interrupts what goes on. Afterwards it is remembered only: an interrupt comes up anywhere, also where
    Python can but print it and go on, and where a library takes it for an error of its own.
    """

    def __init__(self) -> None:
        self.stands = self.asked = False

    def handle_signals(self, *_: object) -> None:
        """The handler of the signals."""
        self.asked = True
        if not self.stands:
            raise KeyboardInterrupt

    def handle_hang_up(self, *_: object) -> None:
        """The terminal is closed: a server in it ends, and any other goes on."""
        if sys.stdin is not None and sys.stdin.isatty():
            self.handle_signals()

    def come(self) -> bool:
        """Whether it was asked for."""
        return self.asked
