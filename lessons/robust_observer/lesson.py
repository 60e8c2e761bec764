"""Robust observer: u = K x estimated directly by one or two states, and what it forgives when the model is wrong."""

from __future__ import annotations

from pathlib import Path

from app.lesson.again import Again
from app.lesson.lesson import Lesson
from app.lesson.prose import read_prose

from ..course import PLACES
from .code import code
from .derive import derived
from .exams import EXAMS
from .figures import all_figures
from .job import JOB
from .knobs import KNOBS
from .own import adapted
from .study import compute
from .tasks import TASKS

LESSON = Lesson("robust-observer", 15, KNOBS, compute, all_figures, answer=2, answering="criterion", tasks=TASKS, exams=EXAMS,
                source="Duan, Li, Zhou (002): robust Luenberger observer design, 1993; there u = +K x",
                place=PLACES["robust-observer"],
                again=Again(("c",), 0, {"c": 0.0}, ("e_u", "gain", "sweep")),
    words=read_prose(Path(__file__).parent), key=("example", "a1", "a2", "b1", "w12"),
    aside=("norm", "alpha", "second", "beta", "gamma", "region_low", "region_high", "remark", "line", "columns"), kick=False,
                job=JOB, adapt=adapted, code=code,
    derived=derived)
