"""List the learning paths through the lessons and the lessons to go on with."""

from __future__ import annotations

from collections.abc import Iterable

from .course_map import LearningPath
from .lesson import Lesson

ONWARD = 3  # lessons that the end of one leads to


def paths_with_lessons(lessons: Iterable[Lesson]) -> dict[LearningPath, list[Lesson]]:
    """The ways with their lessons, both in the order of the lessons."""
    ways: dict[LearningPath, list[Lesson]] = {}
    for lesson in lessons:
        for way in lesson.place.ways:
            ways.setdefault(way, []).append(lesson)
    return ways


def next_lessons(lesson: Lesson, lessons: Iterable[Lesson]) -> list[Lesson]:
    """Lessons to go on with: the next one on each way, then those that build on this one, nearest first."""
    later = [other for other in lessons if other.number > lesson.number]
    found = [next((other for other in later if way in other.place.ways), None) for way in lesson.place.ways]
    found += [other for other in later if lesson.id in other.place.needs]
    return [other for other in dict.fromkeys(found) if other is not None][:ONWARD]
