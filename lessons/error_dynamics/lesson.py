"""Assemble lesson 2: the estimation error does not depend on the input."""

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
from .study import BLOCK_SETTING, compute
from .tasks import TASKS

LESSON = Lesson(
    "error-dynamics",
    2,
    KNOBS,
    partial(compute, BLOCK_SETTING),
    partial(figures, BLOCK_SETTING),
    answer=1,
    answering="error",
    tasks=TASKS,
    exams=EXAMS,
    source="Observer notes (001), equations (1)–(7) and the spring-damper example; tutorial (000)",
    place=COURSE_PLACES["error-dynamics"],
    again=SecondPrediction(("guess_q",), 2, {"guess_q": -1.0}, ("error", "components")),
    words=read_prose(Path(__file__).parent),
    key=("input", "hand", "guess_q"),
    aside=("amplitude", "frequency", "seed", "line"),
    adapt=adapted,
    derived=partial(derived, BLOCK_SETTING),
    path=PATH,
)
