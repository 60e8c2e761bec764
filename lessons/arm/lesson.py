"""Arm: a geared arm with a motor of which the angle alone is measured, and a load torque that its observer finds as a state."""

from __future__ import annotations

from pathlib import Path

from app.lesson.again import Again
from app.lesson.lesson import Lesson
from app.lesson.prose import read_prose

from ..course import PLACES
from .code import code
from .derive import derived
from .exams import EXAMS
from .figures import figures
from .job import JOB
from .knobs import KNOBS
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "arm", 20, KNOBS, compute, figures, answer=1, answering="load", tasks=TASKS, exams=EXAMS,
    source="Tutorial (000), introduction and applications: the arm whose joint speeds are not measured; data sheets of maxon RE 40, "
           "order number 148867, gear GP 42 C, 203116, encoder HEDL 5540, 110514",
    place=PLACES["arm"],
    again=Again(("cancel",), 3, {"cancel": False}, ("angle", "load", "error")),
    words=read_prose(Path(__file__).parent), key=("load_state", "load", "gap"),
    aside=("target", "counts"), derived=derived, code=code, job=JOB)
