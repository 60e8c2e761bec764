"""Place each lesson in the course and define three learning paths."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType

from observer_lab.course.course_map import CoursePlace, LearningPath
from observer_lab.text import text

FIRST_COURSE = LearningPath("first", text("A first course in observers"),
            text("From the virtual sensor to noise: design an observer, steer by it, and see where that ends."))
ESTIMATION = LearningPath("estimation", text("Estimation"),
                 text("How a filter weighs model and sensors: from noise over the Kalman filter to lost packets and faulty sensors."))
PLATFORM_PATH = LearningPath("platform", text("The platform"),
               text("One machine from start to finish: a table that stands still while the ground shakes, by LQG and its rivals."))
MINUTES = 90


def _place(id: str, needs: str, *ways: LearningPath) -> tuple[str, CoursePlace]:
    return id, CoursePlace(MINUTES, tuple(needs.split()), ways, Path(__file__).parent / id.replace("-", "_") / "card.webp")


COURSE_PLACES = MappingProxyType(dict((
    _place("virtual-sensor", "", FIRST_COURSE, ESTIMATION),
    _place("error-dynamics", "virtual-sensor", FIRST_COURSE),
    _place("observability", "error-dynamics", FIRST_COURSE, ESTIMATION),
    _place("separation", "error-dynamics", FIRST_COURSE, PLATFORM_PATH),
    _place("duality", "observability separation", FIRST_COURSE),
    _place("hidden-modes", "observability separation", FIRST_COURSE),
    _place("saturation", "separation", FIRST_COURSE),
    _place("noise", "error-dynamics", FIRST_COURSE, ESTIMATION),
    _place("kalman", "noise", ESTIMATION, PLATFORM_PATH),
    _place("lqg", "separation kalman", PLATFORM_PATH),
    _place("decoupling", "lqg", PLATFORM_PATH),
    _place("weak-states", "observability lqg", PLATFORM_PATH),
    _place("showdown", "lqg decoupling", PLATFORM_PATH),
    _place("nonlinear", "kalman", ESTIMATION),
    _place("robust-observer", "separation duality"),
    _place("bilinear-observer", "observability hidden-modes"),
    _place("fault-diagnosis", "kalman", ESTIMATION),
    _place("network", "separation kalman", ESTIMATION),
    _place("sandbox", "separation"),
    _place("arm", "separation saturation"),
    _place("record", "kalman", ESTIMATION),
)))
