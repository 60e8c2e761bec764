"""Keep the states of all lessons of a tab, also those restored by a reload and not yet opened."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping

from ...course.course_map import Progress
from ...course.knobs import KnobError
from ...course.lesson import Design, Lesson
from ...engine import EngineError
from ...text import Text
from ..runtime.error_words import kept_for_others
from .history import History
from .lesson_state import LessonState
from .tab_memory import progress_in_saved_state, read_lesson_state
from .view import State, progress_of


def lesson_to_open_first(lesson: Lesson, plant: str, say: Callable[[Text, bool], None]) -> Lesson:
    """The lesson as it opens first in a tab: the plant that was shown comes along where it fits, else a sentence is said."""
    if not plant:
        return lesson
    try:
        return lesson.fit(plant)
    except (EngineError, KnobError) as problem:
        say(kept_for_others(problem), False)
        return lesson


class LessonStates:
    """The states of one tab's lessons."""

    def __init__(self, lessons: Mapping[str, Lesson]) -> None:
        self._lessons = lessons
        self._used: dict[str, LessonState] = {}
        self._kept: dict[str, str] = {}

    def of(self, lesson: str, start: Callable[[], Design]) -> LessonState:
        """The state of a lesson: the one in use, the one that was kept, or a new one on `start()`."""
        if lesson not in self._used:
            kept = self._kept.pop(lesson, None)
            found = None if kept is None else read_lesson_state(json.loads(kept), lesson, self._lessons)
            self._used[lesson] = LessonState(History(start())) if found is None else found
        return self._used[lesson]

    def lay(self, lesson: str, design: Design, now: float) -> None:
        """Make a design a lesson's present one; the one before is one step of undo away."""
        self.of(lesson, lambda: design).history.push(design, None, now)

    def reset_lesson(self, lesson: str, start: Design) -> None:
        """Begin the state of a lesson anew."""
        self._used[lesson] = LessonState(History(start))

    def judge_anew(self, lessons: Iterable[str]) -> None:
        """Read the states of these lessons again when they are opened: their lessons are others now, or gone."""
        for lesson in lessons:
            used = self._used.pop(lesson, None)
            if used is not None and used.text:
                self._kept[lesson] = used.text

    def forget(self) -> None:
        """Forget the states of all lessons."""
        self._used, self._kept = {}, {}

    def take_back(self, states: Mapping[str, object]) -> bool:
        """Take kept states in; what is in use stays, with what was kept one step of undo away. True if there was
        such."""
        met = False
        for lesson, data in states.items():
            if lesson not in self._used:
                self._kept[lesson] = json.dumps(data, ensure_ascii=False)
            elif (old := read_lesson_state(data, lesson, self._lessons)) is not None:
                met = self._used[lesson].take_back(old) or met
        return met

    def progress(self, present: str, state: State) -> dict[str, Progress]:
        """How far the person is in each lesson that lies here; what is open now stands in the tab's state."""
        found = {lesson: progress_in_saved_state(json.loads(kept)) for lesson, kept in self._kept.items()}
        found |= {lesson: progress_of(kept.predicted, kept.tasks) for lesson, kept in self._used.items()}
        return {**found, present: progress_of(state.predicted, state.tasks)}

    def written(self, latest: str) -> Iterator[tuple[str, str]]:
        """Lesson and text of every state, the one that is worked on now first, the one left longest ago last."""
        self._used[latest] = self._used.pop(latest)
        yield from ((lesson, kept.text) for lesson, kept in reversed(self._used.items()) if kept.text)
        yield from self._kept.items()
