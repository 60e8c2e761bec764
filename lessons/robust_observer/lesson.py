"""Assemble lesson 15: estimate K x with one or two states, tolerant of model errors."""

from __future__ import annotations

from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose

from ..course import COURSE_PLACES
from .code import code
from .derive import derived
from .exams import EXAMS
from .figures import all_figures
from .job import JOB
from .knobs import KNOBS
from .own import adapted
from .path import PATH
from .study import compute
from .tasks import TASKS

LESSON = Lesson("robust-observer", 15, KNOBS, compute, all_figures, answer=2, answering="criterion", tasks=TASKS, exams=EXAMS,
                source="Duan, Li, Zhou (002): robust Luenberger observer design, 1993; there u = +K x",
                place=COURSE_PLACES["robust-observer"],
                again=SecondPrediction(("c",), 0, {"c": 0.0}, ("e_u", "gain", "sweep")),
    words=read_prose(Path(__file__).parent), key=("example", "a1", "a2", "b1", "w12"),
    aside=("norm", "alpha", "second", "beta", "gamma", "region_low", "region_high", "remark", "line", "columns", "carried"), kick=False,
                job=JOB, adapt=adapted, code=code,
    derived=derived, path=PATH)
