"""Hold what a tab shows. Whatever fails on the way to a picture, the last good one stays."""

from __future__ import annotations

import logging
from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace

from ...classroom.room import VoteDesk
from ...course.lazy import FigureSet, complete_figures
from ...course.lesson import Design, Lesson
from ...text import Text
from ..runtime.background_jobs import BackgroundJobs
from ..runtime.error_words import kept_for_others, refusal_message
from ..runtime.outcomes import LongJob, OutcomeAndFigures, OutcomeCache, PinOutcomes, SceneOutcomes
from ..state.lesson_state import LessonState
from ..state.lesson_states import LessonStates, lesson_to_open_first
from ..state.saved_state import SavedState
from ..state.tab_memory import write_lesson_state, write_memory
from ..state.token import write_token
from ..state.view import Picture, State, View

log = logging.getLogger(__name__)


class Presenter:
    """The tab's picture and the ways it changes. Only the tab's worker calls it."""

    def __init__(self, lessons: Mapping[str, Lesson], view: View, lesson: str, state: State,
                 clock: Callable[[], float], background: BackgroundJobs, vote_desk: VoteDesk | None) -> None:
        self.lessons = dict(lessons)
        self.view, self.clock = view, clock
        self.lesson, self.state = self.lessons[lesson], state
        self.job = LongJob(clock)
        self.background = background
        self.vote_desk = vote_desk  # where the class votes, None in a tab that presents to nobody
        self.run_seeds: Callable[[], object] = lambda: None  # begins the runs of many seeds, or cancels them
        self.resting = True
        self.answered = self.asked = 0  # the edit that is being worked on, or was last; the last state opened from the address bar
        self.last_edit = self.last_tick = self.last_hand = clock()
        self.alone = 0.0  # s from the last tick on in which the view goes on with the run by itself
        self.late, self.said_late = 0, float("-inf")  # how many poses in a row have waited for other tabs; when that was said
        self.lesson_states = LessonStates(self.lessons)
        self.limited_grip: int | None = None  # the last grip of a hand on the plant that reached its limit
        self.touched = False  # whether the person has done anything yet
        self.recalled = False  # whether it is known what the browser's tab kept
        self.insists = False  # whether the server names the lesson or the state that a new tab opens with
        self._drafts = OutcomeCache()
        self._pinning, self._scenes = PinOutcomes(self._drafts, self.lessons), SceneOutcomes(self._drafts)
        self._unsaid: list[tuple[Text, bool]] = []  # sentences that wait for the page
        self._torn = False  # whether laying the page out has failed half-way
        self.shown: Picture | None = None  # the last good picture, None before the first
        self.left_behind: list[Hashable] = []  # how a presenter's page looked before each of its last edits
        self.unfinished: tuple[tuple[tuple[Design, ...], int], Picture | None] | None = None  # the last whole picture, and its history

    @property
    def picture(self) -> Picture:
        """The last good picture of a tab that is open."""
        assert self.shown is not None, "the tab is not open yet"
        return self.shown

    @property
    def design(self) -> Design:
        """The present design, shown or about to be."""
        return self.lesson_state.history.design

    @property
    def lesson_state(self) -> LessonState:
        """What belongs to the present lesson."""
        own, plant = self.lessons[self.lesson.id], self.state.plant if self.shown is None else self.shown.design.plant
        return self.lesson_states.of(own.id, lambda: lesson_to_open_first(own, plant, self.view.say).start())

    # --- lessons ---------------------------------------------------------------------------------------------------
    def open(self) -> None:
        """Compute the lesson's present design and lay the screen out."""
        self.job.drop()
        try:
            self.lesson = self._lesson_for(self.design)
            drawn = self._draw(self.design)
        except BaseException as problem:
            log.exception("the remembered design of lesson %s cannot be computed; it starts anew", self.lesson.id)
            self._unsaid += [(kept_for_others(problem), True)] if self.design.plant else []
            self.lesson = self.lessons[self.lesson.id]
            self.lesson_states.reset_lesson(self.lesson.id, self.lesson.start())
            drawn = self._draw(self.design)
        self.state = self.lesson_state.state_on_opening(self.state)
        self.resting = True
        self.shown = self._make(self.design, drawn)
        self._build_page(self.shown)
        while self._unsaid:
            self.view.say(*self._unsaid.pop(0))

    def open_lesson(self, lesson: str) -> None:
        """Open another lesson; if it cannot be opened, the present one again."""
        if self.job.running:
            self.cancel_job()
        self._write_down()
        before, self.lesson = self.lesson, self.lessons[lesson]
        try:
            self.open()
        except BaseException:
            self.lesson = before
            self.open()
            raise

    def forget_outcomes(self) -> None:
        """Forget what was computed: the files of a lesson have changed."""
        self._drafts, self.unfinished = OutcomeCache(), None
        self._pinning, self._scenes = PinOutcomes(self._drafts, self.lessons), SceneOutcomes(self._drafts)

    def rebuild(self, state: State) -> None:
        """Lay the screen out anew: the language or the size of the print has changed."""
        self.complete()
        self.state = state
        self.shown = self._again()
        self._build_page(self.shown)

    def open_state(self, saved: SavedState) -> None:
        """Open a state that came from elsewhere: its lesson, its design as a step of undo, and how its page looked.

        Raises what its lesson raises at such a design; then nothing was changed.
        """
        design, state = saved.design, self.state
        self._drafts.draw(self.lessons[design.lesson].fit(design.plant), design)
        self.lesson_states.lay(design.lesson, design, self.clock())
        self.state = replace(state, language=saved.language, lecture=saved.lecture, tab=saved.tab, step=saved.step,
                             mode=saved.mode or "lab", camera=saved.camera,
                             plant=design.plant or state.plant, withheld=saved.withheld or state.withheld)
        if self.shown is None:
            self.lesson = self.lessons[design.lesson]
        else:
            self.view.look(saved.camera)
            self.open_lesson(design.lesson)

    def _build_page(self, picture: Picture) -> None:
        self._torn = True
        self.view.build(picture)
        self._torn = False
        self.view.show(picture)
        self.view.pose(self.state.t)
        self.remember()

    def _lesson_for(self, design: Design) -> Lesson:
        """The lesson built for the plant that a design brings."""
        return self.lesson if design.plant == self.lesson.plant else self.lessons[design.lesson].fit(design.plant)

    # --- designs ---------------------------------------------------------------------------------------------------
    def adopt_design(self, design: Design, key: Hashable = None, held: bool = False, moving: bool = False) -> None:
        """Make a design the present one; whatever fails on the way, the last good one stays. While it is `moving` the rest comes later."""
        history = self.lesson_state.history
        if design == history.design and self.shown is not None and design == self.shown.design:
            self.redraw()
            return
        before = history.save()
        history.push(design, key, self.clock(), held)
        self._show_present_design(before, moving)

    def walk(self, step: int) -> bool:
        """So many steps of redo, or of undo where negative; False where there are not so many."""
        history = self.lesson_state.history
        before = history.save()
        if not history.move(step):
            return False
        self._show_present_design(before)
        return True

    def _show_present_design(self, before: tuple[tuple[Design, ...], int], moving: bool = False) -> None:
        """Show the history's present design; if that fails, go back to where the history stood `before`."""
        history, picture, resting, state, lesson = self.lesson_state.history, self.shown, self.resting, self.state, self.lesson
        try:
            self.lesson = self._lesson_for(history.design)
            drawn = self._draw(history.design, whole=not moving)
            horizon = float(drawn[0].stage.t[-1]) if drawn[0].stage is not None else 0.0
            self.state = replace(self.state, t=min(self.state.t, horizon))
            self.resting = False
            self.shown = self._make(history.design, drawn, whole=not moving)
            if self.lesson is not lesson:  # other knobs, other figures
                self.view.build(self.shown)
            self.view.show(self.shown)
            self.view.pose(self.state.t)
        except BaseException:
            rebuilt = self.shown is not picture and self.lesson is not lesson
            history.restore(before)
            self.shown, self.resting, self.state, self.lesson = picture, resting, state, lesson
            if rebuilt and picture is not None:
                self.view.build(picture)
            raise
        self.unfinished = None if self.shown.whole else self.unfinished or (before, picture)
        if self.job.running:
            self.cancel_job()
        self.last_edit = self.clock()

    def complete(self, undisturbed: Callable[[], bool] = lambda: True) -> None:
        """Make and show what a picture under a moving knob lacks, unless disturbed; if that fails, go back to the last whole one."""
        if self.unfinished is None:
            return
        (before, good), picture = self.unfinished, self.picture
        try:
            if complete_figures(picture.figures, undisturbed):
                picture.outcome.complete()
                self.shown, self.unfinished = replace(picture, whole=True), None
                self.view.show(self.shown)
        except BaseException:
            self.lesson_state.history.restore(before)
            self.shown, self.unfinished = good, None
            raise

    def _draw(self, design: Design, whole: bool = True) -> OutcomeAndFigures:
        return self._drafts.draw(self.lesson, design, self.lesson_state.follows, whole)

    # --- pictures --------------------------------------------------------------------------------------------------
    def change(self, state: State) -> None:
        """Show another state of the tab. A run that begins or jumps goes on from now, not from its last pose."""
        before, self.state = self.state, state
        if state.moving and (not before.moving or state.t != before.t):
            self.last_tick, self.alone = self.clock(), 0.0
        self.lesson_state.keep(state)
        self.redraw()
        if state.revealed and not before.revealed and state.tab == state.left:  # who has turned to another is not called back
            self.view.open_figure(self.lesson.answering)
        if state != replace(before, playing=state.playing, loop=state.loop, stopped=state.stopped, t=state.t):
            self.remember()

    def redraw(self) -> None:
        """Show the last good picture with the present state, on a page that is whole."""
        if self.shown is not None:
            self.shown = self._again()
            (self._build_page if self._torn else self.view.show)(self.shown)

    def rest(self) -> None:
        """The knobs rest: what a reload should bring back, and the final picture, whose mark says that both are there."""
        self.complete()
        self.remember()
        self.resting = True
        self.redraw()

    def report_refusal(self, problem: BaseException, command: bool = False) -> None:
        """Say in one sentence why something was not done, and show the last good picture again."""
        self.view.say(refusal_message(problem, command), True)
        self.resting = True
        self.redraw()

    def present(self, drawn: OutcomeAndFigures) -> None:
        """Show an outcome of the present design that no knob has made."""
        picture = self._make(self.picture.design, drawn)
        self.view.show(picture)
        self.shown = picture

    def keep(self, found: object) -> None:
        """Show what the job has found, and remember it for all designs of its key once it can be shown."""
        design = self.picture.design
        self.present(self._drafts.outcome_with_job_result(self.lesson, design, found))
        self._drafts.store_job_result(self.lesson, design, found)

    def mark_job_ended(self) -> None:
        """The long computation is through."""
        self._drafts.end(self.lesson, self.picture.design)

    @property
    def job_ended(self) -> bool:
        """Whether the long computation of the picture's design is through, and what it found is known."""
        return self._drafts.ended(self.lesson, self.picture.design)

    def tell(self, words: Text, bad: bool) -> None:
        """Say a sentence now, or when the page stands."""
        if self.shown is None:
            self._unsaid.append((words, bad))
        else:
            self.view.say(words, bad)

    def cancel_job(self) -> None:
        """End the long computation without a word; the last picture stays."""
        self.job.drop()
        self.view.progress(None, None)

    def _again(self) -> Picture:
        return self._make(self.picture.design, (self.picture.outcome, self.picture.figures), whole=self.unfinished is None)

    def _make(self, design: Design, drawn: OutcomeAndFigures, whole: bool = True) -> Picture:
        history = self.lesson_state.history
        scene = self.state.scene_of(self.lesson.path)
        self.state = replace(self.state, can_undo=history.can_undo and not (scene and history.design == self.lesson_state.began),
                             can_redo=history.can_redo, guided=scene is not None)
        return Picture(self.lesson, design, *drawn, self.state, self.resting, tuple(self.lessons.values()), self.answered,
                       self._pinning.drawn(self.state.pins), *history.save(), whole or not isinstance(drawn[1], FigureSet),
                       *self._scenes.of(self.lesson, scene, self.state.done, self.lesson_state.began, drawn[0]))

    def remember(self) -> None:
        """Keep in the browser's tab what a reload should bring back, once what it keeps is known."""
        if self.recalled:
            self._write_down()
            self.view.remember(write_memory(self.lesson.id, self.state, self.lesson_states.written(self.lesson.id)))
            self.view.address(write_token(self.lesson, self.saved()), self.lesson.id, self.asked)

    def saved(self) -> SavedState:
        """The state as a link carries it."""
        return replace(self.picture, state=self.state).saved(self.design, self.view.eye())

    def _write_down(self) -> None:
        self.lesson_state.text = write_lesson_state(self.lesson, self.lesson_state, self.state)
