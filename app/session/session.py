"""Run one browser tab: take commands from the mailbox, compute the outcome, update the view.

Callbacks post edits in microseconds; one worker thread takes them in order (the latest value of a knob wins, commands
are never dropped), computes the outcome, and tells the view. What commands do is in playing, designing, studying and
paging; what the tab shows is in presenter.
"""

from __future__ import annotations

import logging
import secrets
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any  # what a reader of lessons is given is `Any` here; `ReadLessons` says it

from ..classroom.room import RoomView, VoteDesk
from ..course.handin.learner import Learner
from ..course.handin.served_course import ServedCourse
from ..course.knobs import KnobError
from ..course.lectures import Lecture
from ..course.lesson import Lesson
from ..course.scenes import Mode
from ..engine import EngineError
from .commands.commands import Edit, MemoryRecalled, Notice
from .commands.files import LessonsRead
from .handlers import design, guide, lectures, playback, room, sharing, tasks
from .handlers.many_seeds import SeedRunner
from .handlers.presenter import Presenter
from .handlers.reload import RECALL_TIMEOUT_S, MemoryRequest, restore_memory
from .handlers.table import run_command
from .runtime.background_jobs import BackgroundJobs
from .runtime.scheduler import Scheduler
from .runtime.watchdog import TAB_ENDED, Watchdog
from .runtime.worker import Mailbox, grouped, start_worker
from .state.own_lessons import OwnLessons, ReadLessons
from .state.view import Picture, State, View

log = logging.getLogger(__name__)

SCHEDULER = Scheduler()  # of all tabs of this process
WATCHDOG = Watchdog()  # over all tabs of this process
LAST_MESSAGE_S = 0.5  # s for the last word of a tab that is ended
FINAL_PICTURE_DELAY_S = 0.25  # s without an edit after which the final picture is drawn


class Session:
    """One tab: `post` an edit, and the view shows what it leads to.

    `step` does everything that is due; `start` runs it on a thread of its own.
    """

    def __init__(self, lessons: Mapping[str, Lesson], view: View, lesson: str, language: str = "en",
                 clock: Callable[[], float] = time.monotonic, plant: str = "",
                 state: str = "", insists: bool = False, sealed: bool = False, mode: Mode = "lab", talk: Lecture | None = None,
                 course: ServedCourse | None = None, desk: VoteDesk | None = None, learner: Learner | None = None,
                 read_lessons: ReadLessons | None = None) -> None:
        """`state` is a token, or the words of a saved file, that the tab opens with if nothing else is known of it.

        A new tab goes on where the browser's last one was, unless the server `insists` on its lesson or its state.

        Exams are drawn for a random key until the person gives one; a `sealed` tab only notes answers to them.
        With a `course` its numbers are drawn instead, and its answers are handed in, by a `learner` to the platform.
        A tab that presents to a room has a `desk` there. `read_lessons` reads a .zip of lessons that the person brings, None where
        the server takes none.
        """
        if lesson not in lessons:
            raise KeyError(f"There is no lesson {lesson}; there are {', '.join(lessons)}.")
        self._mailbox, self._state = Mailbox(), state
        first = State(language=language, fresh=secrets.token_hex(8), plant=plant, withheld=sealed, sealed=sealed, mode=mode,
                      talk=talk, lecture=talk is not None, course=course, learner=learner, key=learner.key if learner else "",
                      newcomer=mode == "guide" and not insists and not state and desk is None,
                      room=None if desk is None else RoomView(audience=desk.audience),
                      own=None if read_lessons is None else OwnLessons(partial(self._watched, read_lessons)))
        self._show = Presenter(lessons, view, lesson, first, clock, BackgroundJobs(self.post), desk)
        self._show.insists = insists or bool(state)
        self._seeds = SeedRunner(self._show)
        self._show.run_seeds = self._seeds.start_or_cancel
        self._ended: Callable[[], object] = lambda: None
        self.mirror: Callable[[Edit], object] = lambda edit: None  # is given what a hand has done here, once it is done
        self._recall = MemoryRequest(self._show, lambda *kept: self.post(MemoryRecalled(*kept)))

    # --- outside ---------------------------------------------------------------------------------------------------
    def post(self, edit: Edit, mirrored: bool = False) -> int:
        """Hand an edit over; returns at once, with the number that a picture's `answered` reaches when it is worked
        on. `mirrored` says that a hand has done it on another page."""
        return self._mailbox.post(edit, mirrored)

    def start(self, ended: Callable[[], object] = lambda: None) -> None:
        """Open the lesson and work on a thread until `close`; `ended` is called where the watch had to end the tab."""
        self._ended = ended
        start_worker(self._mailbox, self._begin, self._step_when_due, self._stop_playing)

    def close(self) -> None:
        """End the worker; safe from any thread."""
        self._show.background.forget()
        self._mailbox.close()

    @property
    def picture(self) -> Picture | None:
        """The last good picture, None before the first."""
        return self._show.shown

    # --- the worker ------------------------------------------------------------------------------------------------
    def restore(self, text: str | None, token: str = "", known: bool = False) -> None:
        """Go on where this tab was before a reload, which kept that text; None if it kept nothing. See `MemoryRecalled`."""
        restore_memory(self._show, text, token, known)

    def open(self) -> None:
        """Compute the lesson's present design and lay the screen out."""
        self._show.open()
        lectures.begin(self._show)
        guide.greet(self._show)

    def step(self, wait: float | None = 0.0) -> None:
        """Take what waits, do what is due, when it is this tab's turn."""
        taken = self._mailbox.take(wait)
        with SCHEDULER.turn(hand=bool(taken)) as waited:
            if not taken:
                playback.report_lateness(self._show, waited)
            with WATCHDOG.step(self._left, self._end_from_outside):
                self._work(taken)

    def _work(self, taken: list[tuple[int, Edit]]) -> None:
        if taken or not self._show.resting or self._show.job.running or self._seeds.running:
            playback.catch_up(self._show, self._show.clock())
        for number, edits in grouped(taken):
            if self._mailbox.closed:  # whoever asked has left, and what waits would be done for nobody
                return
            self._show.answered = number
            hand = not isinstance(edits, Notice)
            if hand:
                self._show.touched, self._show.last_hand = True, self._show.clock()
                sharing.note_look(self._show)
            try:
                if self._show.state.frozen and not isinstance(edits, Notice):
                    raise KnobError(room.PAUSED)
                if isinstance(edits, list):
                    design.set_knobs(self._show, edits, moving=True)
                    if not any(map(design.pulls, edits)):
                        playback.replay_while_dragging(self._show)
                else:
                    self._show.complete()
                    run_command(self._show, edits)
                guide.follow(self._show, edits)
                if not self._mailbox.was_mirrored(number):
                    for edit in edits if isinstance(edits, list) else (edits,):
                        self.mirror(edit)
            except (KnobError, EngineError) as problem:
                self._show.report_refusal(problem)
            except BaseException as problem:  # a lesson that asks the process to exit is a lesson that failed
                log.exception("%s failed", "a change of knobs" if isinstance(edits, list) else type(edits).__name__)
                self._show.report_refusal(problem, command=not isinstance(edits, list))
            if hand:  # what it asked for may have taken a while
                self._show.last_hand = self._show.clock()
        self._complete_hidden_figures()
        now = self._show.clock()
        if not self._show.resting and now - self._show.last_edit >= FINAL_PICTURE_DELAY_S:
            self._show.rest()
            tasks.follow(self._show)
            guide.follow(self._show, ())
        self._recall.go_on(now)
        tasks.go_on(self._show, self._mailbox.empty)
        self._seeds.go_on(self._mailbox.empty)
        playback.tick(self._show, now)
        guide.tick(self._show, now)

    def _complete_hidden_figures(self) -> None:
        """What hidden tabs show of the last draft, unless the hand goes on."""
        try:
            self._show.complete(self._mailbox.empty)
        except (KnobError, EngineError) as problem:
            self._show.report_refusal(problem)
        except BaseException as problem:
            log.exception("the figures of hidden tabs failed")
            self._show.report_refusal(problem)

    def _begin(self) -> None:
        if self._state:
            sharing.open_words(self._show, self._state)
        self._recall.ask()
        early: list[tuple[Edit, bool]] = []
        end = time.monotonic() + RECALL_TIMEOUT_S
        while not self._show.recalled and not self._mailbox.closed and (left := end - time.monotonic()) > 0:
            for number, edit in self._mailbox.take(left):
                if isinstance(edit, (MemoryRecalled, LessonsRead)):
                    run_command(self._show, edit)
                else:
                    early.append((edit, self._mailbox.was_mirrored(number)))
        for edit, mirrored in early:
            self._mailbox.post(edit, mirrored)
        if not self._mailbox.closed:  # a page for a tab that has left would cost as much as any
            with SCHEDULER.turn(hand=True), WATCHDOG.step(self._left, self._end_from_outside):
                self.open()

    def _step_when_due(self) -> None:
        self.step(self._wait())

    def _watched(self, read: ReadLessons, *given: Any) -> Iterator[Lesson]:
        """Each lesson of a .zip, read as a step that may be broken off."""
        lessons = read(*given)
        while True:
            with WATCHDOG.step(self._left, self._end_from_outside):
                lesson = next(lessons, None)
            if lesson is None:
                return
            yield lesson

    def _left(self) -> bool:
        return self._mailbox.closed

    def _end_from_outside(self) -> None:
        """End the tab from another thread: its own one does not answer."""
        self.close()
        self._show.view.say(TAB_ENDED, True)
        time.sleep(LAST_MESSAGE_S)
        self._ended()

    def _stop_playing(self) -> None:
        self._show.state = replace(self._show.state, playing=False, loop=None)

    def _wait(self) -> float | None:
        """Seconds until something is due without an edit, None if nothing is."""
        if self._show.job.running or self._seeds.running or self._show.unfinished is not None:
            return 0.0
        now = self._show.clock()
        frame = playback.wait_for_frame(self._show, now)
        rest = None if self._show.resting else max(0.0, self._show.last_edit + FINAL_PICTURE_DELAY_S - now)
        return min((wait for wait in (frame, rest, self._recall.wait(now), guide.wait(self._show, now)) if wait is not None), default=None)
