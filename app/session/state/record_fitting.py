"""Follow the fit of a person's record: how far it is, how long it will last, and a way to end it."""

from __future__ import annotations

import time
from collections.abc import Callable

from ...course.knobs import KnobError
from ...text import text

MOST_FIT_S = 180.0  # s by the clock that a fit may take
SAID_EVERY_S, KNOWN_AFTER_S, KNOWN_SHARE = 0.5, 1.0, 0.03  # s between two reports; s and share after which its end can be estimated
TOO_LONG = text("This fit takes more than {seconds:.0f} s and was ended; use fewer rows or columns.", seconds=MOST_FIT_S)


class FitStopped(Exception):
    """Raised in a fit that nobody waits for any more."""


class RecordFitting:
    """One fit on a thread of its own. `told` is called with it now and then, and returns whether the tab is still open."""

    def __init__(self, told: Callable[[RecordFitting], bool], clock: Callable[[], float] = time.monotonic) -> None:
        self._told, self._clock = told, clock
        self._began = self._said = clock()
        self._stopped = False
        self.share = 0.0  # that is done

    @property
    def seconds_left(self) -> float | None:
        """How long it will go on at this pace, None while that is not known."""
        lasted = self._clock() - self._began
        if lasted < KNOWN_AFTER_S or self.share < KNOWN_SHARE:
            return None
        return lasted * (1 - self.share) / self.share

    def stop(self) -> None:
        """End it at its next word; safe from any thread."""
        self._stopped = True

    def hear(self, share: float) -> None:
        """Note the share that is done. Raises FitStopped in a fit that was ended, and KnobError in one that takes too long."""
        now = self._clock()
        if self._stopped:
            raise FitStopped
        if now - self._began > MOST_FIT_S:
            raise KnobError(TOO_LONG)
        self.share = max(self.share, min(share, 1.0))
        if now - self._said >= SAID_EVERY_S:
            self._said = now
            self._stopped = not self._told(self)
