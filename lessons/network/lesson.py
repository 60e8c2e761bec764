"""Assemble lesson 18: how much packet loss and delay a loop tolerates."""

from __future__ import annotations

from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose

from ..course import COURSE_PLACES
from .code import code
from .derive import derived
from .exams import EXAMS
from .figures import figures
from .job import JOB
from .knobs import KNOBS
from .path import PATH
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "network", 18, KNOBS, compute, figures, answer=3, answering="means", tasks=TASKS, exams=EXAMS,
    source="Sinopoli, Schenato, Franceschetti, Poolla, Jordan, Sastry: Kalman filtering with intermittent observations, 2004; "
           "Mo, Sinopoli: Kalman filtering with intermittent observations, tail distribution and critical value, 2012",
    place=COURSE_PLACES["network"],
    again=SecondPrediction(("delay",), 2, {"delay": 1}, ("spectrum", "state", "blocks")),
    words=read_prose(Path(__file__).parent), key=("a", "stretch", "loss", "delay"), aside=("noise", "order", "lost", "told"), job=JOB,
    code=code,
    derived=derived, path=PATH)
