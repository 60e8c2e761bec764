"""Error dynamics: steer a block on a spring as you like; the error of its observer does not notice."""

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
from .study import BLOCK, compute
from .tasks import TASKS

LESSON = Lesson(
    "error-dynamics", 2, KNOBS, partial(compute, BLOCK), partial(figures, BLOCK), answer=1, answering="error", tasks=TASKS, exams=EXAMS,
    source="Observer notes (001), equations (1)–(7) and the spring-damper example; tutorial (000)",
    place=PLACES["error-dynamics"],
    again=Again(("guess_q",), 2, {"guess_q": -1.0}, ("error", "components")),
    words=read_prose(Path(__file__).parent), key=("input", "hand", "guess_q"),
    aside=("amplitude", "frequency", "seed", "line"), adapt=adapted,
    derived=partial(derived, BLOCK))
