"""Compute the outcomes of pinned designs, once for each pin."""

from __future__ import annotations

import logging
from collections.abc import Mapping

from ...course.lesson import Design, Lesson
from ...course.pinned_designs import Pin, Pinned
from ..runtime.outcomes import OutcomeCache

log = logging.getLogger(__name__)


class PinOutcomes:
    """The outcomes of the pins that are shown now."""

    def __init__(self, drafts: OutcomeCache, lessons: Mapping[str, Lesson]) -> None:
        self._drafts, self._lessons = drafts, lessons
        self._pins: tuple[Pin, ...] = ()
        self._drawn: tuple[Pinned, ...] = ()

    def drawn(self, pins: tuple[Pin, ...]) -> tuple[Pinned, ...]:
        """The pins with what they lead to: the same records as long as the pins are the same. One that cannot be computed is not
        drawn."""
        if pins != self._pins:
            known = {each.pin.design: each for each in self._drawn}
            self._pins = pins
            self._drawn = tuple(found for place, pin in enumerate(pins) if (found := self._pinned(pin, place, known.get(pin.design))))
        return self._drawn

    def _pinned(self, pin: Pin, place: int, known: Pinned | None) -> Pinned | None:
        if known is not None:
            return Pinned(pin, place, known.outcome, known.figures)
        try:
            return Pinned(pin, place, *self.draw(pin.design))
        except Exception:
            log.exception("a pinned design of lesson %s cannot be computed", pin.design.lesson)
            return None

    def draw(self, design: Design):
        """Outcome and figures of a design, with its own plant."""
        return self._drafts.draw(self._lessons[design.lesson].fit(design.plant), design)
