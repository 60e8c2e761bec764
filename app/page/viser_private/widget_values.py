"""Track the value that a browser shows in a widget and when it may be overwritten."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any

import viser

from ...session.state.view import Picture
from . import viser_internals


class ReadBack:
    """The value of one widget, posted when its browser changes it and written when something else has to stand there.

    A change is heard later than it was made, its answer is ready later still, and the hand does not wait for either. So
    every change bears the number of its edit, and nothing is written before the answer that takes the last one up: an
    older value never comes back over a newer one. An answer to just that change, rounded perhaps, waits until the knobs
    rest. A change that was under way while something was written is written back at rest, so that in the end the widget
    shows what holds.
    """

    def __init__(self, handle: Any, post: Callable[[Any], int]) -> None:
        self._handle, self._post = handle, post
        self._shown = handle.value  # what the browser shows, as far as one can know here
        self._number = -1  # of the edit that carries the last change heard
        self._written = self._crossed = False
        self._lock = threading.Lock()  # a change is heard on the server's loop, pictures are shown by the tab's own thread

        @handle.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                self._hear(event.target.value)

    def _hear(self, value: Any) -> None:
        with self._lock:
            self._shown = value
            self._crossed, self._written = self._crossed or self._written, False
            self._number = self._post(value)

    def may_write(self, picture: Picture) -> bool:
        """Whether a picture is new enough to be shown here, and does not disturb the hand that it answers."""
        return picture.answered > self._number or (picture.resting and picture.answered == self._number)

    def forget(self) -> None:
        """The page has written there by itself: what is shown is not known."""
        with self._lock:
            self._shown = None

    def show(self, value: Any, picture: Picture) -> None:
        """Write the value that a picture accepts, if it differs from what stands here and if it may be written."""
        with self._lock:
            same = _same(self._shown, value)
            if not self.may_write(picture) or (same and not (self._crossed and picture.resting)):
                return
            self._written, self._crossed = True, False
            self._shown = value
            viser_internals.write(self._handle, value)


def _same(a: Any, b: Any) -> bool:
    """Whether two values look alike: numbers that differ by rounding alone do."""
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(_same, a, b))
    return a == b or (isinstance(a, float) and isinstance(b, float) and math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12))
