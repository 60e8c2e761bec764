"""Kalman: how a filter knows what to trust, one step at a time, and how it is found out when it believes wrongly."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.lesson.again import Again
from app.lesson.lesson import Lesson
from app.lesson.prose import read_prose
from app.plants.model import Model

from ..course import PLACES
from .code import code, own_code
from .derive import derived
from .exams import EXAMS
from .figures import all_figures
from .job import JOB
from .knobs import KNOBS
from .own import adapted
from .study import compute
from .tasks import TASKS


def _adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, with its script."""
    return replace(adapted(lesson, model), code=own_code)


LESSON = Lesson(
    "kalman", 9, KNOBS, compute, all_figures, answer=2, answering="nees", tasks=TASKS, exams=EXAMS,
    source="Platform report (003), chapter 4: equations (52)–(63), (68)–(70), Algorithm 1, figures 9–11",
    place=PLACES["kalman"],
    again=Again(("q",), 0, {"q": 100.0}, ("nees", "nis", "tests"), numbers=True),
    words=read_prose(Path(__file__).parent), key=("q", "r", "p0"),
    aside=("force", "arithmetic", "line"), job=JOB, adapt=_adapted, code=code,
    derived=derived)
