"""What a tab computes: drafts, kept so that going back costs nothing, and one long job at a time, in slices."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

from ..lesson.figures import Figure
from ..lesson.lesson import Design, Lesson, Outcome

KEPT = 32  # designs whose drafts are remembered, and results of jobs
SLICE = 0.015  # s of a long job between two looks at the mailbox

Drawn = tuple[Outcome, tuple[Figure, ...]]
Key = tuple[str, str, Hashable]  # lesson, plant, what of a design the result of a job rests on
K = TypeVar("K")
V = TypeVar("V")
# What a job finds is `Any` here: each lesson has a record of its own, and only its own functions look into it.


@dataclass(frozen=True, eq=False)
class Draft:
    """A design's outcome as computed, what of a job is shown in it, and both drawn."""

    computed: Outcome
    found: Any
    drawn: Drawn


class Drafts:
    """Outcomes and figures by design, and what jobs have found by what it rests on; the latest ones."""

    def __init__(self) -> None:
        self._known: OrderedDict[Design, Draft] = OrderedDict()
        self._found: OrderedDict[Key, Any] = OrderedDict()

    def draw(self, lesson: Lesson, design: Design) -> Drawn:
        """The draft of a design with what a job has found for its key. Raises what the lesson raises."""
        known, found = self._known.get(design), self._found.get(_key(lesson, design))
        if known is None or known.found is not found:
            known = self._draft(lesson, lesson.compute(design) if known is None else known.computed, found)
        _put(self._known, design, known)
        return known.drawn

    def draw_found(self, lesson: Lesson, design: Design, found: Any) -> Drawn:
        """The draft of a design with what its job has found just now. Raises what the lesson raises."""
        known = self._known.get(design)
        return self._draft(lesson, lesson.compute(design) if known is None else known.computed, found).drawn

    def keep_found(self, lesson: Lesson, design: Design, found: Any) -> None:
        """Remember what a job has found for this design and all others of its key."""
        _put(self._found, _key(lesson, design), found)

    def _draft(self, lesson: Lesson, computed: Outcome, found: Any) -> Draft:
        outcome = computed if found is None or lesson.job is None else lesson.job.shown(computed, found)
        return Draft(computed, found, (outcome, tuple(lesson.figures(outcome))))


def _key(lesson: Lesson, design: Design) -> Key:
    return lesson.id, design.plant, None if lesson.job is None else lesson.job.key(design)


def _put(store: OrderedDict[K, V], key: K, value: V) -> None:
    store[key] = value
    store.move_to_end(key)
    while len(store) > KEPT:
        store.popitem(last=False)


class LongJob:
    """A computation that a person starts, goes on in slices and can be dropped between any two of its steps."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._steps: Iterator[tuple[float, Any]] | None = None
        self._last: Any = None
        self._ended = -1e9

    @property
    def running(self) -> bool:
        """Whether there is more to do."""
        return self._steps is not None

    def ended_within(self, seconds: float) -> bool:
        """Whether a job came to its end by itself just now."""
        return self._clock() - self._ended < seconds

    def start(self, steps: Iterator[tuple[float, Any]]) -> None:
        """Begin with these steps instead of any others."""
        self._steps, self._last = steps, None

    def drop(self) -> None:
        """Forget what is left of it."""
        self._steps = None

    def go_on(self, undisturbed: Callable[[], bool]) -> tuple[float, Any]:
        """Work for a slice of time or until disturbed: the fraction done, and what was found, None if nothing new was.

        Raises what the job raises, and ends then.
        """
        fraction, found, begun = 0.0, self._last, time.monotonic()
        assert self._steps is not None
        try:
            while time.monotonic() - begun < SLICE and undisturbed():
                fraction, new = next(self._steps)
                found = found if new is None else new
        except StopIteration:
            self._steps, self._ended = None, self._clock()
        except BaseException:
            self._steps = None
            raise
        news, self._last = found is not self._last, found
        return fraction, found if news else None
