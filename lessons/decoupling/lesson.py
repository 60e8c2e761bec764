"""Assemble lesson 11: three channels, a mixing, three SISO loops, the published pair and ours."""

from __future__ import annotations

from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose

from ..course import COURSE_PLACES
from .code import code
from .derive import derived
from .exams import EXAMS
from .figures import figures, pick
from .knobs import KNOBS
from .path import PATH
from .study import compute
from .tasks import TASKS

LESSON = Lesson("decoupling", 11, KNOBS, compute, figures, answer=2, answering="spectrum-rotation", tasks=TASKS, exams=EXAMS,
                source="Platform report (003), chapter 2: equations (2)–(38), figures 3–6; section 5.3.3",
                place=COURSE_PLACES["decoupling"],
                again=SecondPrediction(("mix",), 3, {"mix": "best"}, ("spectrum-rotation", "velocity-rotation")),
    words=read_prose(Path(__file__).parent), key=("vertical", "horizontal", "pitch"),
    aside=("lag", "lead", "roll_off", "f_low", "f_high", "lower", "ground", "noise", "sensors", "corner", "knee", "tilt"), pick=pick,
    derived=derived, path=PATH, code=code)
