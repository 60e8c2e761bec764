"""Keep the history of designs for undo and redo; write and read it for a reload."""

from __future__ import annotations

import json
from collections.abc import Hashable, Iterable, Mapping
from contextlib import suppress
from functools import lru_cache
from itertools import pairwise

from ...course.knobs import KnobError
from ...course.lesson import Design, Lesson
from ...engine import EngineError
from .saved_state import NO_STATE, check_state, design_as_plain_data

MERGE_WINDOW_S = 0.8  # s within which changes of the same knobs are one step of undo
MAX_UNDO_DESIGNS = 500  # designs that undo remembers
MAX_HISTORY_CHARACTERS = 20_000  # characters that the steps to one side of the present design may take


class History:
    """Designs that undo and redo walk along."""

    def __init__(self, design: Design) -> None:
        self._designs = [design]
        self._at = 0
        self._key: Hashable = None
        self._time = -1e9

    @property
    def design(self) -> Design:
        """The present design."""
        return self._designs[self._at]

    def push(self, design: Design, key: Hashable, now: float, held: bool = False) -> None:
        """A new present. A quick change with the same key replaces the last one, a `held` one however slow."""
        if design == self.design:
            return
        merge = key is not None and key == self._key and (held or now - self._time <
                                                          MERGE_WINDOW_S) and self._at == len(self._designs) - 1
        if merge and self._at > 0:
            self._designs[self._at] = design
        else:
            self._designs = [*self._designs[: self._at + 1], design][-MAX_UNDO_DESIGNS:]
            self._at = len(self._designs) - 1
        self._key, self._time = key, now

    def insert_before_present(self, design: Design) -> bool:
        """Put a design one step of undo before the present one; False if it is the present one."""
        if design == self.design:
            return False
        designs = [*self._designs[: self._at], design, *self._designs[self._at :]]
        gone = max(len(designs) - MAX_UNDO_DESIGNS, 0)
        self._designs, self._at, self._key = designs[gone:], self._at + 1 - gone, None
        return True

    def save(self) -> tuple[tuple[Design, ...], int]:
        """Where the history stands, for `restore`."""
        return tuple(self._designs), self._at

    def restore(self, saved: tuple[tuple[Design, ...], int]) -> None:
        """Go back to what `save` gave: the last change could not be shown."""
        self._designs, self._at, self._key = list(saved[0]), saved[1], None

    def move(self, step: int) -> bool:
        """Walk by so many steps, back where negative; False where there are not so many."""
        if not 0 <= self._at + step < len(self._designs):
            return False
        self._at += step
        self._key = None
        return True

    @property
    def can_undo(self) -> bool:
        """Whether there is something before."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is something after."""
        return self._at < len(self._designs) - 1


def write_steps(lesson: Lesson, history: History) -> list[list[object]]:
    """[changes back from the present design, changes on from it], the nearest first; nothing where there is one design only."""
    designs, at = history.save()
    ways = [_changes(lesson, designs[at::-1]), _changes(lesson, designs[at:])]
    return ways if any(ways) else []


def read_steps(data: object, whole: Mapping[str, object], present: Design, lessons: Mapping[str, Lesson]) -> History:
    """The history about the present design, which is `whole` in plain data, as far as it can be read."""
    back, on = data if isinstance(data, list) and len(data) == 2 else ((), ())
    before, after = _designs(back, whole, present, lessons), _designs(on, whole, present, lessons)
    history = History(present)
    history.restore(((*reversed(before), present, *after), len(before)))
    return history


def _changes(lesson: Lesson, designs: Iterable[Design]) -> list[object]:
    """What each step changes, until there is no more room."""
    changes: list[object] = []
    left = MAX_HISTORY_CHARACTERS
    for before, after in pairwise(designs):
        change = _change(lesson, before, after)
        left -= len(change)
        if left < 0:
            break
        changes.append(json.loads(change))
    return changes


@lru_cache(maxsize=2048)
def _change(lesson: Lesson, before: Design, after: Design) -> str:
    """[knobs that changed] as JSON; [all knobs, plant] where the plant is another."""
    old, new = design_as_plain_data(lesson, before), design_as_plain_data(lesson, after)
    was, now = old["knobs"], new["knobs"]
    assert isinstance(was, dict) and isinstance(now, dict)
    if before.plant != after.plant:
        return json.dumps([now, new.get("plant")])
    return json.dumps([{name: said for name, said in now.items() if was.get(name) != said}])


def _designs(changes: object, whole: Mapping[str, object], present: Design, lessons: Mapping[str, Lesson]) -> list[Design]:
    """The designs that the changes lead to, up to the first that cannot be read."""
    designs = [present]
    with suppress(KnobError, EngineError, RecursionError, OverflowError):
        for change in changes[: MAX_UNDO_DESIGNS // 2] if isinstance(changes, list) else ():
            whole = _changed(whole, change)
            design = check_state(whole, lessons).design
            if design.lesson == present.lesson and design != designs[-1]:
                designs.append(design)
    return designs[1:]


def _changed(whole: Mapping[str, object], change: object) -> dict[str, object]:
    """A design as plain data after a change. Raises KnobError where it is none."""
    match change, whole.get("knobs"):
        case [dict(knobs)], dict(known):
            return {**whole, "knobs": {**known, **knobs}}
        case [dict(knobs), plant], dict():
            return {**whole, "knobs": knobs, "plant": plant}
    raise KnobError(NO_STATE)
