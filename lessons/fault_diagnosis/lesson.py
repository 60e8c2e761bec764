"""Assemble lesson 17: observer bank, noise-based thresholds, and a loop that reacts."""

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
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "fault-diagnosis", 17, KNOBS, compute, figures, answer=0, answering="isolation", tasks=TASKS, exams=EXAMS,
    source="Chen and Patton, Robust Model-Based Fault Diagnosis for Dynamic Systems (1999), chapter 3; platform report (003), section 3.1",
    place=COURSE_PLACES["fault-diagnosis"],
    again=SecondPrediction(("window",), 0, {"bias": 1.5, "window": 100}, ("sensors", "isolation", "members", "cusum")),
    words=read_prose(Path(__file__).parent), key=("place", "bias", "drift", "loss", "rate"),
    aside=("statistic", "at", "place2", "bias2", "loss2", "at2", "force", "tone", "stiffer"), job=JOB, code=code,
    derived=derived, path=PATH)
