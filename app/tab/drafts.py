"""What a tab computes: drafts, kept so that going back costs nothing, and one long job at a time, in slices."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Iterator

from ..lesson.figures import Figure
from ..lesson.lesson import Design, Lesson, Outcome

KEPT = 32  # designs whose drafts are remembered
SLICE = 0.015  # s of a long job between two looks at the mailbox

Drawn = tuple[Outcome, tuple[Figure, ...]]


class Drafts:
    """Outcomes and figures by design, the latest ones."""

    def __init__(self) -> None:
        self._known: OrderedDict[Design, Drawn] = OrderedDict()

    def draw(self, lesson: Lesson, design: Design, carried: Callable[[Outcome], Outcome]) -> Drawn:
        """The draft of a design; `carried` hands on to it what a job has found. Raises what the lesson raises."""
        known = self._known.get(design)
        outcome = carried(lesson.compute(design) if known is None else known[0])
        drawn = known if known is not None and outcome is known[0] else (outcome, tuple(lesson.figures(outcome)))
        self.keep(design, drawn)
        return drawn

    def keep(self, design: Design, drawn: Drawn) -> None:
        """Remember what was drawn for a design."""
        self._known[design] = drawn
        self._known.move_to_end(design)
        while len(self._known) > KEPT:
            self._known.popitem(last=False)


class LongJob:
    """A computation that a person starts, goes on in slices and can be dropped between any two of its steps."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._steps: Iterator[tuple[float, Outcome]] | None = None
        self._ended = -1e9

    @property
    def running(self) -> bool:
        """Whether there is more to do."""
        return self._steps is not None

    def ended_within(self, seconds: float) -> bool:
        """Whether a job came to its end by itself just now."""
        return self._clock() - self._ended < seconds

    def start(self, steps: Iterator[tuple[float, Outcome]]) -> None:
        """Begin with these steps instead of any others."""
        self._steps = steps

    def drop(self) -> None:
        """Forget what is left of it."""
        self._steps = None

    def go_on(self, undisturbed: Callable[[], bool]) -> tuple[float, Outcome | None]:
        """Work for a slice of time or until disturbed: the fraction done, and the last outcome if there was one.

        Raises what the job raises, and ends then.
        """
        fraction, outcome, begun = 0.0, None, time.monotonic()
        assert self._steps is not None
        try:
            while time.monotonic() - begun < SLICE and undisturbed():
                fraction, outcome = next(self._steps)
        except StopIteration:
            self._steps, self._ended = None, self._clock()
        except Exception:
            self._steps = None
            raise
        return fraction, outcome
