"""Assemble lesson 20: an observer that estimates the load torque of an arm from its angle."""

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
    "arm", 20, KNOBS, compute, figures, answer=1, answering="load", tasks=TASKS, exams=EXAMS,
    source="Tutorial (000), introduction and applications: the arm whose joint speeds are not measured; data sheets of maxon RE 40, "
           "order number 148867, gear GP 42 C, 203116, encoder HEDL 5540, 110514",
    place=COURSE_PLACES["arm"],
    again=SecondPrediction(("cancel",), 3, {"cancel": False}, ("angle", "load", "error")),
    words=read_prose(Path(__file__).parent), key=("load_state", "load", "gap"),
    aside=("target", "counts"), derived=derived, code=code, job=JOB, path=PATH)
