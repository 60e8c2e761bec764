"""Every lesson's desk: those in use, and those that came back with a reload and wait until their lesson is opened."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping

from ..engine import EngineError
from ..lesson.course import Progress
from ..lesson.knobs import KnobError
from ..lesson.lesson import Design, Lesson
from ..text import Text, told
from .desk import Desk
from .history import History
from .memory import how_far, read_desk
from .picture import State, far


def first_of(lesson: Lesson, plant: str, say: Callable[[Text, bool], None]) -> Lesson:
    """The lesson as it opens first in a tab: the plant that was shown comes along where it fits, else a sentence is said."""
    if not plant or lesson.adapt is None:
        return lesson
    try:
        return lesson.fit(plant)
    except (EngineError, KnobError) as problem:
        say(told(problem), False)
        return lesson


class Desks:
    """The desks of one tab, by lesson."""

    def __init__(self, lessons: Mapping[str, Lesson]) -> None:
        self._lessons = lessons
        self._used: dict[str, Desk] = {}
        self._kept: dict[str, str] = {}

    def of(self, lesson: str, start: Callable[[], Design]) -> Desk:
        """The desk of a lesson: the one in use, the one that was kept, or a new one on `start()`."""
        if lesson not in self._used:
            kept = self._kept.pop(lesson, None)
            found = None if kept is None else read_desk(json.loads(kept), lesson, self._lessons)
            self._used[lesson] = Desk(History(start())) if found is None else found
        return self._used[lesson]

    def lay(self, lesson: str, design: Design, now: float) -> None:
        """Put a design on a lesson's desk; what lay there is one step of undo away."""
        self.of(lesson, lambda: design).history.push(design, None, now)

    def renew(self, lesson: str, start: Design) -> None:
        """Clear a desk away for a new one."""
        self._used[lesson] = Desk(History(start))

    def forget(self) -> None:
        """Clear all desks away."""
        self._used, self._kept = {}, {}

    def take_back(self, desks: Mapping[str, object]) -> bool:
        """Take kept desks in; what is in use stays, with what was kept one step of undo away. True if there was
        such."""
        met = False
        for lesson, data in desks.items():
            if lesson not in self._used:
                self._kept[lesson] = json.dumps(data, ensure_ascii=False)
            elif (old := read_desk(data, lesson, self._lessons)) is not None:
                met = self._used[lesson].take_back(old) or met
        return met

    def progress(self, present: str, state: State) -> dict[str, Progress]:
        """How far the person is in each lesson that lies here; what is open now stands in the tab's state."""
        found = {lesson: how_far(json.loads(kept)) for lesson, kept in self._kept.items()}
        found |= {lesson: far(desk.predicted, desk.tasks) for lesson, desk in self._used.items()}
        return {**found, present: far(state.predicted, state.tasks)}

    def written(self, latest: str) -> Iterator[tuple[str, str]]:
        """Lesson and text of every desk, the one that is worked on now first, the one left longest ago last."""
        self._used[latest] = self._used.pop(latest)
        yield from ((lesson, desk.text) for lesson, desk in reversed(self._used.items()) if desk.text)
        yield from self._kept.items()
