"""Duality: one problem worn twice. The observer of (A, C) is the controller of (Aᵀ, Cᵀ), read sideways."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from app.lesson.again import Again
from app.lesson.lesson import Lesson
from app.lesson.prose import read_prose

from ..course import PLACES
from .derive import derived
from .exams import EXAMS
from .figures import all_figures
from .knobs import KNOBS
from .own import adapted
from .study import BLOCK, compute
from .tasks import TASKS

LESSON = Lesson(
    "duality", 5, KNOBS, partial(compute, BLOCK), partial(all_figures, BLOCK), answer=2, answering="gains", tasks=TASKS, exams=EXAMS,
    source="Tutorial (000), duality section: L = K_dᵀ; observer notes (001), spring-damper example",
    place=PLACES["duality"],
    again=Again(("sensor",), 2, {"sensor": 90.0}, ("gains",), numbers=True),
    words=read_prose(Path(__file__).parent), key=("sensor", "q", "mirror"), aside=("window",), adapt=adapted,
    derived=partial(derived, BLOCK))
