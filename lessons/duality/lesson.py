"""Assemble lesson 5: the observer of (A, C) is the controller of (Aᵀ, Cᵀ), transposed."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose

from ..course import COURSE_PLACES
from .derive import derived
from .exams import EXAMS
from .figures import all_figures
from .knobs import KNOBS
from .own import adapted
from .path import PATH
from .study import BLOCK_SETTING, compute
from .tasks import TASKS

LESSON = Lesson(
    "duality",
    5,
    KNOBS,
    partial(compute, BLOCK_SETTING),
    partial(all_figures, BLOCK_SETTING),
    answer=2,
    answering="gains",
    tasks=TASKS,
    exams=EXAMS,
    source="Tutorial (000), duality section: L = K_dᵀ; observer notes (001), spring-damper example",
    place=COURSE_PLACES["duality"],
    again=SecondPrediction(("sensor",), 2, {"sensor": 90.0}, ("gains",), numbers=True),
    words=read_prose(Path(__file__).parent),
    key=("sensor", "q", "mirror"),
    aside=("window",),
    adapt=adapted,
    derived=partial(derived, BLOCK_SETTING),
    path=PATH,
)
