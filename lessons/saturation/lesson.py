"""Assemble lesson 7: commanded or applied input for the observer, and the recovery map."""

from __future__ import annotations

from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose

from ..course import COURSE_PLACES
from .derive import derived
from .exams import EXAMS
from .figures import figures
from .job import JOB, pick
from .knobs import KNOBS
from .own import adapted
from .path import PATH
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "saturation", 7, KNOBS, compute, figures, answer=3, answering="error", tasks=TASKS, exams=EXAMS,
    source="Tutorial (000), section on the limits of the separation principle",
    place=COURSE_PLACES["saturation"],
    again=SecondPrediction(("error0",), 1, {"error0": 0.0}, ("state1", "state0", "error", "input")),
    words=read_prose(Path(__file__).parent), key=("fed", "u_max", "error0"), job=JOB, pick=pick, adapt=adapted,
    derived=derived, path=PATH)
