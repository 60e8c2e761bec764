"""Assemble lesson 9: a Kalman filter step by step, and tests of its consistency."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose
from observer_lab.plants.model import Model

from ..course import COURSE_PLACES
from .code import code, own_code
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


def _adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, with its script."""
    return replace(adapted(lesson, model), code=own_code)


LESSON = Lesson(
    "kalman", 9, KNOBS, compute, all_figures, answer=2, answering="nees", tasks=TASKS, exams=EXAMS,
    source="Platform report (003), chapter 4: equations (52)–(63), (68)–(70), Algorithm 1, figures 9–11",
    place=COURSE_PLACES["kalman"],
    again=SecondPrediction(("q",), 0, {"q": 100.0}, ("nees", "nis", "tests"), numbers=True),
    words=read_prose(Path(__file__).parent), key=("q", "r", "p0"),
    aside=("force", "arithmetic", "line", "density", "step", "push", "period"), job=JOB, seeds=run_seeds, adapt=_adapted, code=code,
    derived=derived, path=PATH)
