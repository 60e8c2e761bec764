"""Define the course: prerequisites, learning paths, and a person's progress."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..text import Text


@dataclass(frozen=True)
class LearningPath:
    """A way through some of the lessons, in the order of their numbers."""

    id: str
    title: Text
    said: Text


@dataclass(frozen=True)
class CoursePlace:
    """Where a lesson stands in the course: how long it takes in class, what comes before it, on which ways it lies, its picture."""

    minutes: int = 0
    needs: tuple[str, ...] = ()
    ways: tuple[LearningPath, ...] = ()
    picture: Path | None = None


NO_PLACE = CoursePlace()  # of a lesson that is in no course


@dataclass(frozen=True)
class Progress:
    """How far a person is in a lesson; `predicted` once there was a choice, be it to skip."""

    predicted: bool = False
    solved: int = 0
