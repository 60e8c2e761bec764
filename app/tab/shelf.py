"""Designs that a person keeps under names of their own, as a browser's storage holds them: judged when they come back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from ..lesson.lesson import Lesson
from .state import LONGEST, LONGEST_NAME

MOST = 60  # designs that are kept
ROOM = 60_000  # bytes that all of them take: what a browser keeps comes back in one message, which has its bound


@dataclass(frozen=True)
class Kept:
    """A design under a name: `words` are those of a saved state, judged when it is opened."""

    name: str
    lesson: str
    words: str


def read_shelf(written: str | None, lessons: Mapping[str, Lesson]) -> tuple[Kept, ...]:
    """What a browser says that it keeps; whatever is no design under a name is passed over."""
    try:
        data = json.loads(written) if written and len(written) <= 10 * ROOM else None
    except (ValueError, RecursionError):
        return ()
    found = [Kept(name, lesson, words) for name, words in data.items() if (lesson := _lesson_of(name, words, lessons))
             ] if isinstance(data, dict) else []
    return tuple(found[:MOST])


def _lesson_of(name: str, words: object, lessons: Mapping[str, Lesson]) -> str | None:
    """The lesson of what is kept under a name, None if it is not one."""
    if not isinstance(words, str) or len(words) > LONGEST or not 0 < len(name) <= LONGEST_NAME or not name.isprintable():
        return None
    try:
        data = json.loads(words)
    except (ValueError, RecursionError):
        return None
    lesson = data.get("lesson") if isinstance(data, dict) else None
    return lesson if isinstance(lesson, str) and lesson in lessons else None
