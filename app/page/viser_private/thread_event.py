"""Provide an event of the server's loop that other threads may set.

viser rings one for every message that a tab's thread writes. An event of asyncio is not made for that: it wakes who waits from the
wrong thread and goes through the list of them while the loop changes it. Once in some thousands of pages that raised an error in
the middle of a picture, and half a page was sent.
"""

from __future__ import annotations

import asyncio


class LoopEvent(asyncio.Event):
    """Set from another thread it is set at once, and wakes nobody; who waits is woken when the loop itself sets it, set or not.

    viser asks the loop to do so after every message, or at the end of a block of them.
    """

    _value: bool

    def set(self) -> None:
        """Set it."""
        try:
            asyncio.get_running_loop()
        except RuntimeError:  # another thread
            self._value = True
            return
        self._value = False  # asyncio wakes nobody where it is set already
        super().set()
