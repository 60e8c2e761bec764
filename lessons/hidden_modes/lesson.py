"""Hidden modes: bolts on the boards. What leaves no trace cannot be corrected; what is out of reach cannot be moved."""

from __future__ import annotations

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
from .study import compute
from .tasks import TASKS

LESSON = Lesson("hidden-modes", 6, KNOBS, compute, all_figures, answer=0, answering="error_parts", tasks=TASKS, exams=EXAMS,
                source="Tutorial (000), section on the limits of the theory: detectable and stabilizable; PBH test",
                place=PLACES["hidden-modes"],
                again=Again(("controller_all",), 3, {"controller_all": (-4 - 1j, -4 + 1j, -4.5 - 3j, -4.5 + 3j)},
                ("centre", "state_parts", "input")),
    words=read_prose(Path(__file__).parent), key=("plant", "centre"), adapt=adapted,
    derived=derived)
