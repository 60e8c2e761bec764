"""Write and read the undo history for a reload, storing only what each step changes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import lru_cache
from itertools import pairwise

from ...course.knobs import KnobError
from ...course.lesson import Design, Lesson
from ...engine import EngineError
from .history import MAX_UNDO_DESIGNS, History
from .saved_state import NO_STATE, check_state, design_as_plain_data

MAX_HISTORY_CHARACTERS = 20_000  # characters that the steps to one side of the present design may take


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
