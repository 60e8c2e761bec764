"""Assemble lesson 13: which controller isolates best, by which measure, on real hardware."""

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
from .job import JOB
from .knobs import KNOBS
from .path import PATH
from .seeds import run_seeds
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "showdown", 13, KNOBS, compute, figures, answer=0, answering="suppression", tasks=TASKS, exams=EXAMS,
    source="Platform report (003), chapters 2.3, 5.3 and 6, figures 3–25; limits of section 6.2",
    place=COURSE_PLACES["showdown"],
    again=SecondPrediction(("damping",), 1, {"damping": -90.0}, ("suppression", "sizes", "channel_rotation")),
    words=read_prose(Path(__file__).parent), key=("play", "sensor", "test"), aside=(
        "delay", "limited", "limit", "driver", "bandwidth", "adc", "drift", "friction", "stiffness", "damping", "placement"), job=JOB,
    seeds=run_seeds, derived=derived, path=PATH, code=code)
