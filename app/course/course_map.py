"""Define the course: prerequisites, learning paths, and a person's progress."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from ..text import Text, text


@dataclass(frozen=True)
class LearningPath:
    """A way through some of the lessons, in the order of their numbers."""

    id: str
    title: Text
    said: Text


LEARNING_PATHS: Mapping[str, LearningPath] = MappingProxyType({way.id: way for way in (
    LearningPath("first", text("A first course in observers"),
                 text("From the virtual sensor to noise: design an observer, steer by it, and see where that ends.")),
    LearningPath("estimation", text("Estimation"),
                 text("How a filter weighs model and sensors: from noise over the Kalman filter to lost packets and faulty sensors.")),
    LearningPath("platform", text("The platform"),
                 text("One machine from start to finish: a table that stands still while the ground shakes, by LQG and its rivals.")))})


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
