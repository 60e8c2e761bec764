"""Assemble lesson 1: an open-loop copy of the chip beside a Luenberger observer."""

from __future__ import annotations

from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose

from ..course import COURSE_PLACES
from .derive import derived
from .exams import EXAMS
from .figures import figures
from .knobs import KNOBS
from .own import adapted
from .path import PATH
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "virtual-sensor", 1, KNOBS, compute, figures, answer=0, answering="error", tasks=TASKS, exams=EXAMS,
    source="Tutorial (000), sections on the virtual sensor and on the error's own life",
    place=COURSE_PLACES["virtual-sensor"],
    again=SecondPrediction(("observer_poles",), 1, {"observer_poles": (-3.2 - 1j, -3.2 + 1j)}, ("core", "error", "innovation")),
    words=read_prose(Path(__file__).parent), key=("plant", "trust", "guess_core"), aside=("power", "guess_case"), adapt=adapted,
    derived=derived, path=PATH)
