"""Separation: two pole boards, one loop. The spectrum of 2n poles is the union; the transient still suffers."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from app.lesson.again import Again
from app.lesson.lesson import Lesson
from app.lesson.prose import read_prose

from ..course import PLACES
from .derive import derived
from .exams import EXAMS
from .figures import figures
from .knobs import KNOBS
from .own import adapted
from .study import DECK, compute
from .tasks import TASKS

LESSON = Lesson(
    "separation", 4, KNOBS, partial(compute, DECK), partial(figures, DECK), answer=1, answering="spectrum", tasks=TASKS, exams=EXAMS,
    source="Tutorial (000), separation section, equations of the augmented loop",
    place=PLACES["separation"],
    again=Again(("stiffness_error",), 3, {"stiffness_error": 10.0}, ("spectrum", "blocks"), numbers=True),
    words=read_prose(Path(__file__).parent), key=("stiffness_error", "delay", "noise"), adapt=adapted, derived=partial(derived, DECK))
