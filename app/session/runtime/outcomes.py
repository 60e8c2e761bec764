"""Compute designs, those of scenes and pins too, cache outcomes, and run a long job in slices."""

from __future__ import annotations

import logging
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from ...course.figures.records import Figure
from ...course.guiding.questions import Asked, DrawnQuestion
from ...course.lazy import FigureSet, complete_figures
from ...course.lesson import Design, Lesson, Outcome
from ...course.pinned_designs import Pin, Pinned
from ...course.scenes import Choose, Scene

CACHED_DESIGNS = 32  # designs whose drafts are remembered, and results of jobs
SLICE_S = 0.015  # s of a long job between two looks at the mailbox
MAX_PROGRESS_GAP_S = 0.4  # s for which a job that goes on beside the hand may show nothing new

OutcomeAndFigures = tuple[Outcome, Sequence[Figure]]
Key = tuple[str, str, Hashable]  # lesson, plant, what of a design the result of a job rests on
K = TypeVar("K")
V = TypeVar("V")
log = logging.getLogger(__name__)
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
        """Whether a quiet one shows what it has found so far: where it has shown nothing for MAX_PROGRESS_GAP_S seconds."""
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


class SceneOutcomes:
    """The outcome and the question's figure of the scene that is open, the latest ones kept."""

    def __init__(self, drafts: OutcomeCache) -> None:
        self._drafts = drafts
        self._kept: Outcome | None = None
        self._question: tuple[tuple[str, str, Design, Design], DrawnQuestion] | None = None  # and what it rests on

    def of(self, lesson: Lesson, scene: Scene | None, done: Mapping[str, Design], began: Design | None, present: Outcome) -> tuple[
            Outcome | None, Design | None, DrawnQuestion | None, Outcome | None]:
        """The outcome with which a scene was `done`, None where it is not; the design with which it `began`; its question's figure;
        the outcome with which a question is asked.

        All are None where no scene is open.
        """
        if scene is None:
            return None, None, None, None
        began, kept = began or present.design, done.get(scene.id)
        asked = self._drafts.draw(lesson, began)[0] if isinstance(scene.do, Choose) and began != present.design else None
        return self._outcome(lesson, kept, present), began, self._figure(lesson, scene, began, kept), asked

    def _outcome(self, lesson: Lesson, done: Design | None, present: Outcome) -> Outcome | None:
        if done is None or done == present.design:
            return None if done is None else present
        if self._kept is None or self._kept.design != done:
            self._kept = self._drafts.draw(lesson, done)[0]
        return self._kept

    def _figure(self, lesson: Lesson, scene: Scene, began: Design, done: Design | None) -> DrawnQuestion | None:
        draw = lesson.questions.get(scene.id)
        if draw is None:
            return None
        after = done or lesson.apply(began, scene.play)
        key = lesson.id, scene.id, began, after
        if self._question is None or self._question[0] != key:
            self._question = key, draw(Asked(lesson, *(self._drafts.draw(lesson, each)[0] for each in (began, after))))
        return self._question[1]



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
