"""Saturation: what the observer is told while the force is clipped, and which starts still come home."""

from __future__ import annotations

from pathlib import Path

from app.lesson.again import Again
from app.lesson.lesson import Lesson
from app.lesson.prose import read_prose

from ..course import PLACES
from .derive import derived
from .exams import EXAMS
from .figures import figures
from .job import JOB, pick
from .knobs import KNOBS
from .own import adapted
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "saturation", 7, KNOBS, compute, figures, answer=3, answering="error", tasks=TASKS, exams=EXAMS,
    source="Tutorial (000), section on the limits of the separation principle",
    place=PLACES["saturation"],
    again=Again(("error0",), 1, {"error0": 0.0}, ("state1", "state0", "error", "input")),
    words=read_prose(Path(__file__).parent), key=("fed", "u_max", "error0"), job=JOB, pick=pick, adapt=adapted,
    derived=derived)
