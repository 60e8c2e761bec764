"""Decoupling: three channels of the platform, a mixing, three simple loops; the report's pair as printed and our own."""

from __future__ import annotations

from pathlib import Path

from app.lesson.again import Again
from app.lesson.lesson import Lesson
from app.lesson.prose import read_prose

from ..course import PLACES
from .code import code
from .derive import derived
from .exams import EXAMS
from .figures import figures, pick
from .knobs import KNOBS
from .study import compute
from .tasks import TASKS

LESSON = Lesson("decoupling", 11, KNOBS, compute, figures, answer=2, answering="spectrum-rotation", tasks=TASKS, exams=EXAMS,
                source="Platform report (003), chapter 2: equations (2)–(38), figures 3–6; section 5.3.3",
                place=PLACES["decoupling"],
                again=Again(("mix",), 3, {"mix": "best"}, ("spectrum-rotation", "velocity-rotation")),
    words=read_prose(Path(__file__).parent), key=("vertical", "horizontal", "pitch"),
    aside=("f_low", "f_high", "lower", "ground", "noise"), pick=pick,
    derived=derived, code=code)
