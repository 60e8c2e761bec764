"""Assemble lesson 4: the loop's 2n poles are the union of controller and observer poles."""

from __future__ import annotations

from functools import partial
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
from .study import DECK_SETTING, compute
from .tasks import TASKS

LESSON = Lesson(
    "separation",
    4,
    KNOBS,
    partial(compute, DECK_SETTING),
    partial(figures, DECK_SETTING),
    answer=1,
    answering="spectrum",
    tasks=TASKS,
    exams=EXAMS,
    source="Tutorial (000), separation section, equations of the augmented loop",
    place=COURSE_PLACES["separation"],
    again=SecondPrediction(("stiffness_error",), 3, {"stiffness_error": 10.0}, ("spectrum", "blocks"), numbers=True),
    words=read_prose(Path(__file__).parent),
    key=("stiffness_error", "delay", "noise"),
    aside=("r", "v", "command", "integral", "limited", "u_max"),
    adapt=adapted,
    derived=derived,
    path=PATH,
)
