"""Compute designs, cache their outcomes, and run one long job at a time in slices."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from ...course.figures.records import Figure
from ...course.lazy import FigureSet, complete_figures
from ...course.lesson import Design, Lesson, Outcome

CACHED_DESIGNS = 32  # designs whose drafts are remembered, and results of jobs
SLICE_S = 0.015  # s of a long job between two looks at the mailbox
MAX_PROGRESS_GAP_S = 0.4  # s for which a job that goes on beside the hand may show nothing new

OutcomeAndFigures = tuple[Outcome, Sequence[Figure]]
Key = tuple[str, str, Hashable]  # lesson, plant, what of a design the result of a job rests on
K = TypeVar("K")
V = TypeVar("V")
# What a job finds is `Any` here: each lesson has a record of its own, and only its own functions look into it.


@dataclass(frozen=True, eq=False)
class CachedOutcome:
    """A design's outcome as computed, what of a job is shown in it, and both drawn."""

    computed: Outcome
    found: Any
    drawn: OutcomeAndFigures


class OutcomeCache:
    """Outcomes and figures by design, and what jobs have found by what it rests on; the latest ones."""

    def __init__(self) -> None:
        self._known: OrderedDict[Design, CachedOutcome] = OrderedDict()
        self._found: OrderedDict[Key, Any] = OrderedDict()
        self._through: OrderedDict[Key, bool] = OrderedDict()

    def draw(self, lesson: Lesson, design: Design, rough: bool = False, whole: bool = True) -> OutcomeAndFigures:
        """The draft of a design with what a job has found for its key, or with a `rough` result where there is one and nothing found.

        What may come later is made now where `whole` is asked for.
        Raises what the lesson raises.
        """
        known, found = self._known.get(design), self._found.get(_key(lesson, design))
        if known is None or known.found is not found:
            computed = lesson.compute(design) if known is None else known.computed
            coarse = lesson.job.rough if rough and found is None and lesson.job is not None else None
            drawn = self._draft(lesson, computed, found if coarse is None else coarse(computed)).drawn
            known = CachedOutcome(computed, found, drawn)
        _put(self._known, design, known)
        return _whole(known.drawn) if whole else known.drawn

    def outcome_with_job_result(self, lesson: Lesson, design: Design, found: Any) -> OutcomeAndFigures:
        """The draft of a design with what its job has found just now. Raises what the lesson raises."""
        known = self._known.get(design)
        return _whole(self._draft(lesson, lesson.compute(design) if known is None else known.computed, found).drawn)

    def store_job_result(self, lesson: Lesson, design: Design, found: Any) -> None:
        """Remember what a job has found for this design and all others of its key."""
        _put(self._found, _key(lesson, design), found)

    def end(self, lesson: Lesson, design: Design) -> None:
        """The job of this design, and of all others of its key, is through."""
        _put(self._through, _key(lesson, design), True)

    def ended(self, lesson: Lesson, design: Design) -> bool:
        """Whether it is, and what it found is still kept."""
        key = _key(lesson, design)
        return key in self._through and key in self._found

    def _draft(self, lesson: Lesson, computed: Outcome, found: Any) -> CachedOutcome:
        outcome = computed if found is None or lesson.job is None else lesson.job.shown(computed, found)
        figures = lesson.figures(outcome)
        return CachedOutcome(computed, found, (outcome, figures if isinstance(figures, FigureSet) else tuple(figures)))


def _whole(drawn: OutcomeAndFigures) -> OutcomeAndFigures:
    outcome, figures = drawn
    complete_figures(figures, lambda: True)
    outcome.complete()
    return drawn


def _key(lesson: Lesson, design: Design) -> Key:
    return lesson.id, design.plant, None if lesson.job is None else lesson.job.key(design)


def _put(store: OrderedDict[K, V], key: K, value: V) -> None:
    store[key] = value
    store.move_to_end(key)
    while len(store) > CACHED_DESIGNS:
        store.popitem(last=False)


class LongJob:
    """A computation that a person starts, goes on in slices and can be dropped between any two of its steps."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._steps: Iterator[tuple[float, Any]] | None = None
        self._last: Any = None
        self.quiet = False  # whether it goes on beside the hand: without a bar, and shown now and then and when it is through
        self._ended = self._told = -1e9

    @property
    def running(self) -> bool:
        """Whether there is more to do."""
        return self._steps is not None

    def ended_within(self, seconds: float) -> bool:
        """Whether a job came to its end by itself just now."""
        return self._clock() - self._ended < seconds

    @property
    def found(self) -> Any:
        """What it has found so far, None if nothing."""
        return self._last

    def start(self, steps: Iterator[tuple[float, Any]], quiet: bool = False) -> None:
        """Begin with these steps instead of any others."""
        self._steps, self._last, self.quiet, self._told = steps, None, quiet, self._clock()

    def tells(self) -> bool:
        """Whether a quiet one shows what it has found so far: where it has shown nothing for SILENT seconds."""
        if self._last is None or self._clock() - self._told < MAX_PROGRESS_GAP_S:
            return False
        self._told = self._clock()
        return True

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
            while time.monotonic() - begun < SLICE_S and undisturbed():
                fraction, new = next(self._steps)
                found = found if new is None else new
        except StopIteration:
            self._steps, self._ended = None, self._clock()
        except BaseException:
            self._steps = None
            raise
        news, self._last = found is not self._last, found
        return fraction, found if news else None
