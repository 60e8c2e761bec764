"""Read and check the named designs that a browser stores."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...course.lesson import Lesson
from ...text import read_outside_json
from .saved_state import LONGEST_NAME, MAX_STATE_CHARACTERS

MAX_SAVED_DESIGNS = 60  # designs that are kept
MAX_SAVED_BYTES = 60_000  # bytes that all of them take: what a browser keeps comes back in one message, which has its bound


@dataclass(frozen=True)
class SavedDesign:
    """A design under a name: `words` are those of a saved state, judged when it is opened."""

    name: str
    lesson: str
    words: str


def read_saved_designs(written: str | None, lessons: Mapping[str, Lesson]) -> tuple[SavedDesign, ...]:
    """What a browser says that it keeps; whatever is no design under a name is passed over."""
    try:
        data = read_outside_json(written) if written and len(written) <= 10 * MAX_SAVED_BYTES else None
    except ValueError:
        return ()
    found = [SavedDesign(name, lesson, words) for name, words in data.items() if (lesson := _lesson_of(name, words, lessons))
             ] if isinstance(data, dict) else []
    return tuple(found[:MAX_SAVED_DESIGNS])


def _lesson_of(name: str, words: object, lessons: Mapping[str, Lesson]) -> str | None:
    """The lesson of what is kept under a name, None if it is not one."""
    if not isinstance(words, str) or len(words) > MAX_STATE_CHARACTERS or not 0 < len(name) <= LONGEST_NAME or not name.isprintable():
        return None
    try:
        data = read_outside_json(words)
    except ValueError:
        return None
    lesson = data.get("lesson") if isinstance(data, dict) else None
    return lesson if isinstance(lesson, str) and lesson in lessons else None
