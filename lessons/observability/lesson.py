"""Assemble lesson 3: which sensors determine the state, by O, distances and data."""

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
from .knobs import KNOBS
from .own import adapted
from .path import PATH
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "observability", 3, KNOBS, compute, figures, answer=3, answering="modes", tasks=TASKS, exams=EXAMS, kick=False,
    source="Observer notes (001), section 2: observability matrix, rank criterion; PBH test; Gramian",
    place=COURSE_PLACES["observability"],
    again=SecondPrediction(("noise",), 0, {"noise": 0.003}, ("ellipses", "halves", "energy")),
    words=read_prose(Path(__file__).parent), key=("plant", "left", "right_on", "angle", "gap", "count"),
    aside=("criterion", "tolerance", "reading", "noise", "second", "apart"), adapt=adapted, code=code,
    derived=derived, path=PATH)
