"""Kalman: how a filter knows what to trust, one step at a time, and how it is found out when it believes wrongly."""

from __future__ import annotations

from pathlib import Path

from app.lesson.lesson import Lesson
from app.lesson.prose import read_prose

from .code import code
from .derive import derived
from .figures import all_figures
from .job import JOB
from .knobs import KNOBS
from .own import adapted
from .study import compute
from .tasks import TASKS, exam

LESSON = Lesson(
    "kalman", 9, KNOBS, compute, all_figures, answer=2, answering="nees", tasks=TASKS, exam=exam,
    source="Platform report (003), chapter 4: equations (52)–(63), (68)–(70), Algorithm 1, figures 9–11",
    words=read_prose(Path(__file__).parent), aside=("force", "arithmetic", "line"), job=JOB, adapt=adapted, code=code,
    derived=derived)
