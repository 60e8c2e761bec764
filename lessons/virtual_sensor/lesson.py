"""Virtual sensor: the core that nobody can touch. An open-loop copy of the chip beside a Luenberger observer."""

from __future__ import annotations

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
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "virtual-sensor", 1, KNOBS, compute, figures, answer=0, answering="error", tasks=TASKS, exams=EXAMS,
    source="Tutorial (000), sections on the virtual sensor and on the error's own life",
    place=PLACES["virtual-sensor"],
    again=Again(("observer_poles",), 1, {"observer_poles": (-3.2 - 1j, -3.2 + 1j)}, ("core", "error", "innovation")),
    words=read_prose(Path(__file__).parent), key=("plant", "trust", "guess_core"), aside=("power",), adapt=adapted,
    derived=derived)
