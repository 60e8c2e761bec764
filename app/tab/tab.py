"""How a tab works: a mailbox, a worker, the playback clock, the history of designs. Knows only a View protocol.

Callbacks post edits in microseconds; one worker thread takes them in order (the latest value of a knob wins, commands
are never dropped), computes the outcome, and tells the view. Bad input costs one sentence and nothing else.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace
from typing import Any

from ..engine import EngineError
from ..lesson.figures import Figure
from ..lesson.knobs import KnobError
from ..lesson.lesson import Design, Lesson, Outcome
from ..sentences import kind_of, told
from ..text.words import Text
from .desk import Desk
from .drafts import Drafts, LongJob
from .edits import Do, Mailbox, SetKnobs, grouped
from .history import History
from .picture import Picture, State, View
from .state import read_tab, write_tab
from .thread import start_worker

log = logging.getLogger(__name__)

FRAME = 1 / 30  # s between poses while playing
REST = 0.25  # s without an edit after which the final picture is drawn
JUST_ENDED = 0.7  # s after a long job in which its button means "cancel" to a hand that was about to press it

CANCELLED = Text("Computation cancelled; the last picture stays.", "计算已取消，保留上一幅图。")
NOT_DONE = Text("That could not be done ({0}); everything stays as it was.", "操作未能完成（{0}），一切保持原样。")
BROKEN = Text("The lesson could not compute this design ({0}); the last good picture stays. Undo or change a knob.",
              "课程无法计算这一设计（{0}），保留上一幅正确的图。请撤销或调整旋钮。")


class TabWorker:
    """One tab at work. `step` does everything that is due; `start` runs it on a thread of its own."""

    def __init__(self, lessons: Mapping[str, Lesson], view: View, lesson: str, language: str = "en",
                 clock: Callable[[], float] = time.monotonic, exam_seed: int = 1, plant: str = "") -> None:
        if lesson not in lessons:
            raise KeyError(f"There is no lesson {lesson}; there are {', '.join(lessons)}.")
        self._lessons = dict(lessons)
        self._view = view
        self._clock = clock
        self._mailbox = Mailbox()
        self._desks: dict[str, Desk] = {}
        self._drafts, self._job = Drafts(), LongJob(clock)
        self._state = State(language=language, exam_seed=exam_seed, plant=plant)
        self._lesson = self._lessons[lesson]
        self._picture: Picture | None = None
        self._resting = True
        self._last_edit = self._last_tick = clock()

    # --- outside ---------------------------------------------------------------------------------------------------
    def post(self, edit: SetKnobs | Do) -> None:
        """Hand an edit over; returns at once."""
        self._mailbox.post(edit)

    def start(self) -> None:
        """Open the lesson and work on a thread until `close`."""
        start_worker(self._mailbox, self._begin, self._step_when_due, self._stop_playing)

    def close(self) -> None:
        """End the worker; safe from any thread."""
        self._mailbox.close()

    @property
    def picture(self) -> Picture | None:
        """The last good picture."""
        return self._picture

    def _begin(self) -> None:
        self.restore(self._view.recall())
        self.open()

    def _step_when_due(self) -> None:
        self.step(self._wait())

    def _stop_playing(self) -> None:
        self._state = replace(self._state, playing=False)

    def _wait(self) -> float | None:
        """Seconds until something is due without an edit, None if nothing is."""
        now = self._clock()
        if self._job.running:
            return 0.0
        waits = []
        if self._state.playing:
            waits.append(max(0.0, self._last_tick + FRAME - now))
        if not self._resting:
            waits.append(max(0.0, self._last_edit + REST - now))
        return min(waits) if waits else None

    # --- inside ----------------------------------------------------------------------------------------------------
    def open(self) -> None:
        """Compute the lesson's present design and lay the screen out."""
        self._job.drop()
        try:
            self._lesson = self._lesson_for(self._desk().history.design)
            outcome, figures = self._compute(self._desk().history.design)
        except Exception:
            log.exception("the remembered design of lesson %s cannot be computed; it starts anew", self._lesson.id)
            self._lesson = self._lessons[self._lesson.id]
            self._desks[self._lesson.id] = Desk(History(self._lesson.start()))
            outcome, figures = self._compute(self._desk().history.design)
        desk = self._desk()
        self._state = desk.laid_out(self._state)
        self._resting = True
        self._picture = self._make(desk.history.design, outcome, figures)
        self._view.build(self._picture)
        self._view.show(self._picture)
        self._view.pose(0.0)
        self._remember()

    def restore(self, text: str | None) -> None:
        """Go on where this tab was before a reload; what cannot be read is left at its start."""
        tab = read_tab(text, self._lessons)
        if tab is None:
            return
        self._lesson = self._lessons[tab.design.lesson]
        self._state = replace(self._state, language=tab.language, lecture=tab.lecture, plant=tab.plant)
        self._desks[self._lesson.id] = Desk(History(tab.design), tab.predicted, tab.revealed)

    def step(self, wait: float | None = 0.0) -> None:
        """Take what waits, do what is due."""
        for edits in grouped(self._mailbox.take(wait)):
            try:
                if isinstance(edits, Do):
                    self._do(edits)
                else:
                    self._set(edits)
            except (KnobError, EngineError) as problem:
                self._refuse(problem)
            except Exception as problem:
                log.exception("%r failed", edits)
                self._refuse(problem, isinstance(edits, Do))
        now = self._clock()
        if not self._resting and now - self._last_edit >= REST:
            self._rest()
        if self._job.running:
            self._work_on_job()
        if self._state.playing and now - self._last_tick >= FRAME * 0.9:
            self._tick(now)

    def _rest(self) -> None:
        """The knobs rest: the final picture, and what a reload should bring back."""
        self._resting = True
        self._redraw()
        self._remember()

    def _desk(self) -> Desk:
        if self._lesson.id not in self._desks:
            self._desks[self._lesson.id] = Desk(History(self._first().start()))
        return self._desks[self._lesson.id]

    def _first(self) -> Lesson:
        """The lesson as it opens first in this tab: the plant that was shown comes along where it fits."""
        lesson = self._lessons[self._lesson.id]
        plant = self._state.plant if self._picture is None else self._picture.design.plant
        if not plant or lesson.adapt is None:
            return lesson
        try:
            return lesson.fit(plant)
        except (EngineError, KnobError) as problem:
            self._view.say(told(problem), False)
            return lesson

    def _lesson_for(self, design: Design) -> Lesson:
        """The lesson built for the plant that a design brings."""
        if design.plant == self._lesson.plant:
            return self._lesson
        return self._lessons[design.lesson].fit(design.plant)

    def _compute(self, design: Design) -> tuple[Outcome, tuple[Figure, ...]]:
        return self._drafts.draw(self._lesson, design, self._carried)

    def _carried(self, outcome: Outcome) -> Outcome:
        """The outcome with what the job found for the design on the screen, where the lesson says that it still holds."""
        shown = self._picture
        if self._lesson.carry is None or shown is None or shown.lesson is not self._lesson:
            return outcome
        return self._lesson.carry(shown.outcome, outcome)

    def _make(self, design: Design, outcome: Outcome, figures: tuple[Figure, ...]) -> Picture:
        history = self._desk().history
        self._state = replace(self._state, can_undo=history.can_undo, can_redo=history.can_redo)
        return Picture(self._lesson, design, outcome, figures, self._state, self._resting,
                       tuple(self._lessons.values()))

    def _refuse(self, problem: Exception, command: bool = False) -> None:
        """Say in one sentence why something was not done, and show the last good picture again."""
        if isinstance(problem, (EngineError, KnobError)):
            text = told(problem)
        else:
            text = (NOT_DONE if command else BROKEN).format(kind_of(problem))
        self._view.say(text, True)
        self._resting = True
        self._redraw()

    def _redraw(self) -> None:
        if self._picture is not None:
            self._picture = self._make(self._picture.design, self._picture.outcome, self._picture.figures)
            self._view.show(self._picture)

    def _remember(self) -> None:
        """Keep in the browser's tab what a reload should bring back."""
        self._view.remember(write_tab(self._lesson, self._desk().history.design, self._state))

    def _set(self, edits: list[SetKnobs]) -> None:
        """Change knobs: validate, compute once, show, remember. A refused edit does not take a good one with it."""
        design, keys, refused, grip = self._desk().history.design, set[str](), None, None
        for edit in edits:
            try:
                design = self._lesson.apply(design, edit.values)
                keys |= edit.values.keys()
                grip = edit.grip if edit.grip is not None else grip
            except KnobError as problem:
                refused = problem
        if keys:
            self._adopt(design, (frozenset(keys), grip), grip is not None)
        if refused is not None:
            raise refused

    def _adopt(self, design: Design, key: Hashable, held: bool = False) -> None:
        """Make a design the present one; whatever fails on the way, the last good one stays."""
        history = self._desk().history
        if design == history.design and self._picture is not None and design == self._picture.design:
            self._redraw()
            return
        before = history.save()
        history.push(design, key, self._clock(), held)
        self._draw_present(before)

    def _draw_present(self, before: tuple[tuple[Design, ...], int]) -> None:
        """Show the history's present design; if that fails, go back to where the history stood `before`."""
        history, picture, resting, state, lesson = (self._desk().history, self._picture, self._resting, self._state,
                                                    self._lesson)
        try:
            self._lesson = self._lesson_for(history.design)
            outcome, figures = self._compute(history.design)
            horizon = float(outcome.stage.t[-1]) if outcome.stage is not None else 0.0
            self._state = replace(self._state, t=min(self._state.t, horizon))
            self._resting = False
            self._picture = self._make(history.design, outcome, figures)
            if self._lesson is not lesson:  # other knobs, other figures
                self._view.build(self._picture)
            self._view.show(self._picture)
            self._view.pose(self._state.t)
        except Exception:
            rebuilt = self._picture is not picture and self._lesson is not lesson
            history.restore(before)
            self._picture, self._resting, self._state, self._lesson = picture, resting, state, lesson
            if rebuilt and picture is not None:
                self._view.build(picture)
            raise
        if self._job.running:
            self._cancel(silent=True)
        self._last_edit = self._clock()

    def _tick(self, now: float) -> None:
        if self._picture is None:
            return
        t = self._state.t + min(now - self._last_tick, 0.25) * self._picture.rate
        self._last_tick = now
        ended = t >= self._picture.horizon
        self._state = replace(self._state, t=min(t, self._picture.horizon), playing=not ended)
        self._view.pose(self._state.t)
        if ended:
            self._change(revealed=True)

    # --- jobs ------------------------------------------------------------------------------------------------------
    def _work_on_job(self) -> None:
        """Go on with the long job for a slice of time; a job that fails ends, and the last good picture stays."""
        assert self._lesson.job is not None and self._picture is not None
        try:
            fraction, outcome = self._job.go_on(self._mailbox.empty)
            if outcome is not None and outcome is not self._picture.outcome:
                self._keep(outcome)
        except Exception as problem:
            log.exception("the job of lesson %s failed", self._lesson.id)
            self._job.drop()
            self._view.progress(None, None)
            self._refuse(problem)
            return
        self._view.progress(fraction if self._job.running else None, self._lesson.job.label)

    def _keep(self, outcome: Outcome) -> None:
        assert self._picture is not None
        figures = tuple(self._lesson.figures(outcome))
        picture = self._make(self._picture.design, outcome, figures)
        self._view.show(picture)
        self._picture = picture
        self._drafts.keep(picture.design, (outcome, figures))

    def _cancel(self, silent: bool) -> None:
        self._job.drop()
        self._view.progress(None, None)
        if not silent:
            self._view.say(CANCELLED, False)

    def _do(self, command: Do) -> None:
        handler = getattr(self, f"_do_{command.name}", None)
        if handler is None:
            raise KnobError(Text(f"There is no command {command.name[:40]}.", f"没有命令 {command.name[:40]}。"))
        handler(command.argument)

    def _change(self, **changes: Any) -> None:
        """Change the tab's state and show it."""
        self._state = replace(self._state, **changes)
        self._desk().keep(self._state)
        self._redraw()
        if not changes.keys() <= {"playing", "t"}:
            self._remember()
