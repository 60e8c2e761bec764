"""Observability: which sensor sees everything? Rows of O, distances, and the states that the data so far allow."""

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
from .knobs import KNOBS
from .own import adapted
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "observability", 3, KNOBS, compute, figures, answer=3, answering="modes", tasks=TASKS, exams=EXAMS, kick=False,
    source="Observer notes (001), section 2: observability matrix, rank criterion; PBH test; Gramian",
    place=PLACES["observability"],
    again=Again(("noise",), 0, {"noise": 0.003}, ("ellipses", "halves", "energy")),
    words=read_prose(Path(__file__).parent), key=("plant", "left", "right_on", "angle", "gap", "count"),
    aside=("tolerance", "reading", "noise"), adapt=adapted, code=code,
    derived=derived)
