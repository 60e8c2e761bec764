"""Run a design on many seeds, one for each follower of a class, and show the cloud of errors."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...classroom.room import ClassRuns, OwnRun
from ...course.knobs import KnobError
from ...course.lesson import Design
from ...course.many_seeds import SEED_COUNT, SeedErrors
from ...engine import EngineError
from ...text import languages, text
from ..runtime.outcomes import LongJob
from ..state.tab_records import ManySeeds
from .presenter import Presenter

SHOW_GAP_S = 0.2  # s between two pictures of a cloud that grows
MAX_POINTS = 60  # of the course that a follower's page draws
NO_SEEDS = text("This lesson runs no seeds of its own plant; open lesson noise, kalman, showdown or nonlinear.")
SENT_DIGITS, TINY = 4, 1e-30  # digits of a number that a follower's page draws, and the least size that has them

log = logging.getLogger(__name__)


class SeedRunner:
    """The runs of one tab. What was found stands until the design changes."""

    def __init__(self, show: Presenter) -> None:
        self._show, self._desk = show, show.vote_desk
        self._job = LongJob(show.clock)
        self._design: Design | None = None
        self._seats: tuple[int, ...] = ()
        self._told = 0.0
        self._published = False

    @property
    def running(self) -> bool:
        """Whether there is more to do."""
        return self._job.running

    def start_or_cancel(self) -> None:
        """Begin with the seeds of those who follow, or with seeds alone where nobody does. Raises KnobError."""
        show = self._show
        if self.running:
            self.forget()
            return
        if show.lesson.seeds is None:
            raise KnobError(NO_SEEDS)
        self.forget()
        drawn = {} if self._desk is None else dict(self._desk.draw_seeds())
        self._seats = tuple(drawn)
        seeds = (np.array(list(drawn.values())) if drawn else
                 np.random.SeedSequence(int(show.design["seed"])).generate_state(SEED_COUNT))
        self._job.start(show.lesson.seeds(show.picture.outcome, seeds))
        self._design, self._told = show.picture.design, show.clock()
        self._tell(None, 0.0)

    def go_on(self, undisturbed: Callable[[], bool]) -> None:
        """Work for a slice of time; forget what belongs to another design."""
        show = self._show
        if self._design is None:
            return
        if show.picture.design != self._design:
            self.forget()
            return
        if not self.running:
            return
        try:
            fraction, _ = self._job.go_on(undisturbed)
            done, found = not self.running, self._job.found
            if done and found is not None:
                _ = found.judged  # an error of this comes here, and not while a page is drawn
        except BaseException as problem:
            if not isinstance(problem, (KnobError, EngineError)):
                log.exception("the seeds of lesson %s failed", show.lesson.id)
            self.forget()
            show.report_refusal(problem)
            return
        if done or show.clock() - self._told >= SHOW_GAP_S:
            self._told = show.clock()
            self._tell(found, None if done else fraction)
        if done and found is not None and self._seats and self._desk is not None:
            self._published = True
            self._desk.show_runs(class_runs(found, self._seats))

    def forget(self) -> None:
        """Drop what goes on and what was found, here and on the pages of the class."""
        self._job.drop()
        self._design = None
        if self._published and self._desk is not None:
            self._published = False
            self._desk.show_runs(None)
        if self._show.state.many is not None:
            self._show.state = replace(self._show.state, many=None)
            self._show.redraw()

    def _tell(self, found: SeedErrors | None, fraction: float | None) -> None:
        assert self._design is not None
        self._show.state = replace(self._show.state, many=ManySeeds(self._design, found, fraction, bool(self._seats)))
        self._show.redraw()


def class_runs(found: SeedErrors, seats: tuple[int, ...]) -> ClassRuns:
    """What each follower's page draws of its own run."""
    at = np.unique(np.linspace(0, len(found.times) - 1, MAX_POINTS).round().astype(int))
    sigmas = np.broadcast_to(found.sigmas, found.paths.shape)
    return ClassRuns({code: found.names[0](code) for code in languages()}, _short(found.times[at]),
                     {seat: OwnRun(_short(found.paths[k, at]), _short(sigmas[k, at]), bool(found.inside[k]))
                      for k, seat in enumerate(seats) if found.kept[k]})


def _short(values: np.ndarray) -> tuple[float, ...]:
    unit = 10.0 ** (np.floor(np.log10(np.maximum(np.abs(values), TINY))) - (SENT_DIGITS - 1))
    return tuple((np.round(values / unit) * unit).tolist())
