"""Fault diagnosis: which sensor lies? A bank of observers, thresholds from the noise, and a loop that acts on the verdict."""

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
    "fault-diagnosis", 17, KNOBS, compute, figures, answer=0, answering="isolation", tasks=TASKS, exams=EXAMS,
    source="Chen and Patton, Robust Model-Based Fault Diagnosis for Dynamic Systems (1999), chapter 3; platform report (003), section 3.1",
    place=PLACES["fault-diagnosis"],
    again=Again(("window",), 0, {"bias": 1.5, "window": 100}, ("sensors", "isolation", "members", "cusum")),
    words=read_prose(Path(__file__).parent), key=("place", "bias", "drift", "loss", "rate"),
    aside=("at", "place2", "bias2", "loss2", "at2", "force", "tone", "stiffer"), job=JOB, code=code,
    derived=derived)
