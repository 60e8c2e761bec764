"""Assemble lesson 12: ranks depend on units, Hankel values do not; the mode that was cut."""

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

LESSON = Lesson("weak-states", 12, KNOBS, compute, figures, answer=1, answering="shapes", tasks=TASKS, exams=EXAMS, kick=False,
                source="Platform report (003), chapter 3: rank, Hankel values (39), truncation, section 3.3",
                place=COURSE_PLACES["weak-states"],
                again=SecondPrediction(("order",), 0, {"order": 9}, ("error",)),
    words=read_prose(Path(__file__).parent), key=("pair", "order", "clock"),
    aside=("ground", "measure", "h", "a", "mu", "kp", "v0", "pressed"), code=code,
    derived=derived, path=PATH, adapt=adapted)
