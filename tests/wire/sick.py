"""A lesson that misbehaves at some values of a knob, for tests and for the soak."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.lessons import LESSONS

KNOB, LABEL = "stiffness_error", "stiffness error in the model [%]"
RAISES, EXITS, LOOPS, HOARDS, BLOCKS = 10.0, 11.0, 12.0, 13.0, 14.0
GOOD = LESSONS["separation"]
RATE = 20_000  # bytes that it hoards in a thousandth of a second


class Sick:
    """A lesson that misbehaves at some values of a knob; `at` is the last of these, `back` lets it come back."""

    def __init__(self, rate: int = RATE, blocks: float | None = None) -> None:
        self.at, self.back, self.rate, self.blocks = 0.0, threading.Event(), rate, blocks

    @property
    def lesson(self) -> Lesson:
        """The lesson, in place of the good one."""
        return replace(GOOD, compute=self.compute)

    def compute(self, design: Design) -> Outcome:
        """What the good lesson computes, if it comes to that."""
        value = design[KNOB]
        if value in (RAISES, EXITS, LOOPS, HOARDS, BLOCKS):
            self.at = value
        if value == RAISES:
            raise ZeroDivisionError
        if value == EXITS:
            raise SystemExit
        if value == BLOCKS:
            self.back.wait(self.blocks)  # no instruction of Python comes before it is over
        hoard: list[bytes] = []
        while value in (LOOPS, HOARDS):
            if value == HOARDS:
                hoard.append(b"x" * self.rate)
                time.sleep(0.001)  # so much and no more, whatever else goes on
        return GOOD.compute(design)
