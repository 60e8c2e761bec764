"""Assemble lesson 14: extended and unscented filters, judged by their consistency."""

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
from .seeds import run_seeds
from .study import compute
from .tasks import TASKS

LESSON = Lesson(
    "nonlinear", 14, KNOBS, compute, figures, answer=3, answering="errors", tasks=TASKS, exams=EXAMS,
    source="Platform report (003), chapter 4, Algorithms 1–3, and appendix B; Athans, Wishner and Bertolini (1968); Julier, Uhlmann and "
           "Durrant-Whyte (2000); Tichavský, Muravchik and Nehorai (1998)",
    place=COURSE_PLACES["nonlinear"],
    again=SecondPrediction(("sensor",), 2, {"sensor": 0.1}, ("nees", "nis", "verdicts", "errors")),
    words=read_prose(Path(__file__).parent), key=("case", "filter", "size"),
    aside=("force", "wind", "steer", "alpha", "beta", "kappa", "redraw", "line"), job=JOB, seeds=run_seeds, code=code,
    derived=derived, path=PATH)
