"""Restore a tab after a reload, and write nothing to the browser before it has answered.

The answer may be late, on a busy server or a bad line, and it may never come: a script as client keeps nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from ...course.knobs import KnobError
from ...text import text
from ..state.saved_state import read_saved_designs
from ..state.tab_memory import TabMemory, read_memory
from ..state.validate import check_number, check_pixels
from . import sharing
from .lesson_reload import note_lost_lessons, read_kept_lessons
from .presenter import Presenter

RECALL_TIMEOUT_S = 3.0  # s that a tab waits for the answer before it opens without
MAX_ASK_INTERVAL_S = 60.0  # s between two questions at last; the time between them doubles
LATE_MEMORY = text("Your work from before the reload has arrived late: one step of undo brings it back.")


class MemoryRequest:
    """The question what the tab kept, asked until it is answered."""

    def __init__(self, show: Presenter, answer: Callable[..., object]) -> None:
        self._show, self._answer = show, answer
        self._pause, self._next = RECALL_TIMEOUT_S, 0.0

    def ask(self) -> None:
        """Ask now, and later again."""
        self._next = self._show.clock() + self._pause
        self._pause = min(2 * self._pause, MAX_ASK_INTERVAL_S)
        self._show.view.recall(self._answer)

    def wait(self, now: float) -> float | None:
        """Seconds until the next question, None once there is an answer."""
        return None if self._show.recalled else max(0.0, self._next - now)

    def go_on(self, now: float) -> None:
        """Ask again if it is time."""
        if not self._show.recalled and now >= self._next:
            self.ask()


def restore_memory(show: Presenter, text: str | None, token: str = "", known: bool = False, earlier: str | None = None,
                   shelf: str | None = None, window: tuple[object, object, object] | None = None, lessons: str | None = None) -> None:
    """Go on where this tab was, or keep what the person has done meanwhile and put what was kept beside
    it. A new tab goes on where the browser's last one was. A token in the address bar that this tab has not put there itself is
    opened over it. The tab's own .zip of lessons is read before that."""
    if show.recalled or (show.state.own is not None and show.state.own.reading):
        return
    if lessons and read_kept_lessons(show, lessons, lambda: restore_memory(show, text, token, known, earlier, shelf, window)):
        return
    show.recalled = True
    show.state = replace(show.state, shelf=read_saved_designs(shelf, show.lessons))
    if window is not None and show.shown is None:  # a page that stands has told of its window by now
        across, up, night = window
        with suppress(KnobError):
            show.state = replace(show.state, window=(check_pixels(across), check_pixels(up)), night=bool(check_number(night)))
    memory = read_memory(text, show.lessons, show.lesson.id)
    if text or earlier or token:
        show.state = replace(show.state, newcomer=False)
    if memory is not None:
        _go_on(show, memory)
    elif (before := read_memory(earlier, show.lessons, show.lesson.id)) is not None:
        _begin_from(show, before)
    if token and known and memory is not None:
        sharing.look_again(show, token)
    elif token:
        sharing.open_words(show, token)
    if memory is not None and memory.own[0]:
        note_lost_lessons(show, *memory.own)
    if show.shown is not None:
        show.remember()


def _go_on(show: Presenter, memory: TabMemory) -> None:
    if show.touched:
        _put_beside(show, memory)
        return
    show.lesson_states.forget()
    show.lesson_states.take_back(memory.lesson_states)
    show.lesson = show.lessons[memory.lesson]
    show.state = replace(show.state, language=memory.language, lecture=memory.lecture, dark=memory.dark,
                         plant=memory.plant or show.state.plant, key=_key(show, memory), word=memory.word,
                         fresh=memory.fresh or show.state.fresh, withheld=memory.withheld or show.state.withheld,
                         mode=memory.mode or show.state.mode, talk=memory.talk, stop=memory.stop, hand_ins=_signed(show, memory))
    if show.shown is not None:
        show.open()


def _begin_from(show: Presenter, earlier: TabMemory) -> None:
    """A new tab: what was predicted, solved, pinned and designed before is there; exams are drawn anew."""
    state = show.state
    memory = replace(earlier, fresh=state.fresh, withheld=state.withheld, talk=None)
    if not show.insists:
        _go_on(show, memory)
        return
    show.lesson_states.take_back(memory.lesson_states)
    show.state = replace(state, dark=memory.dark, plant=state.plant or memory.plant, key=_key(show, memory), word=memory.word,
                         hand_ins=_signed(show, memory))
    if show.shown is not None:
        show.open()


def _key(show: Presenter, memory: TabMemory) -> str:
    """The student's key: a learning platform's word comes before the browser's."""
    return memory.key if show.state.learner is None else show.state.learner.key


def _signed(show: Presenter, memory: TabMemory) -> dict[str, str]:
    """The hand-ins that this server's course has signed; those of other students are not shown to whom a platform has sent."""
    course, learner = show.state.course, show.state.learner
    if course is None:
        return {}
    held = {name: course.handed(name, token) for name, token in memory.hand_ins.items()}
    return {name: memory.hand_ins[name] for name, hand_in in held.items() if hand_in and (not learner or hand_in.student == learner.key)}


def _put_beside(show: Presenter, memory: TabMemory) -> None:
    met = show.lesson_states.take_back(memory.lesson_states)
    kept = show.lesson_state
    show.change(replace(show.state, predicted=kept.predicted, revealed=kept.revealed, again=kept.again, tasks=kept.tasks, exams=kept.exams,
                        pins=kept.pins, plant=show.state.plant or memory.plant, key=show.state.key or memory.key,
                        word=show.state.word or memory.word,
                        fresh=memory.fresh or show.state.fresh, withheld=show.state.withheld or memory.withheld,
                        hand_ins={**_signed(show, memory), **show.state.hand_ins}))
    if met:
        show.view.say(LATE_MEMORY, False)
