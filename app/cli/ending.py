"""Remember that somebody has asked a server for its end."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

ENDINGS = (signal.SIGINT, signal.SIGTERM)
KILLS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))  # what ends a process without a word


@contextmanager
def ended_as_by_ctrl_c() -> Iterator[None]:
    """SIGTERM and a closed terminal interrupt what goes on, so that children end and files are put away; what is ignored stays so."""
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt
    asked = KILLS if threading.current_thread() is threading.main_thread() else ()
    before = {kill: signal.signal(kill, interrupt) for kill in asked if signal.getsignal(kill) is signal.SIG_DFL}
    try:
        yield
    finally:
        for kill, handler in before.items():
            signal.signal(kill, handler)


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
