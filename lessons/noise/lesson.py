"""Assemble lesson 8: a very fast observer amplifies noise; find the best speed."""

from __future__ import annotations

from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose

from ..course import COURSE_PLACES
from .derive import derived
from .exams import EXAMS
from .figures import all_figures
from .job import JOB
from .knobs import KNOBS
from .own import adapted
from .path import PATH
from .seeds import run_seeds
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "noise", 8, KNOBS, compute, all_figures, answer=0, answering="valley", tasks=TASKS, exams=EXAMS,
    source="Observer notes (001) on fast poles; platform report (003), section 4.1, equations (43)–(50)",
    place=COURSE_PLACES["noise"],
    again=SecondPrediction(("v",), 2, {"v": 0.0064}, ("valley", "peaks", "shares"), numbers=True),
    words=read_prose(Path(__file__).parent), key=("speed", "w", "v"),
    job=JOB, seeds=run_seeds, adapt=adapted,
    derived=derived, path=PATH)
