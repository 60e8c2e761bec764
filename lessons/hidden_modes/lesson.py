"""Assemble lesson 6: no gain moves an unobservable or uncontrollable mode."""

from __future__ import annotations

from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose

from ..course import COURSE_PLACES
from .derive import derived
from .exams import EXAMS
from .figures import all_figures
from .knobs import KNOBS
from .own import adapted
from .path import PATH
from .study import compute
from .tasks import TASKS

LESSON = Lesson("hidden-modes", 6, KNOBS, compute, all_figures, answer=0, answering="error_parts", tasks=TASKS, exams=EXAMS,
                source="Tutorial (000), section on the limits of the theory: detectable and stabilizable; PBH test",
                place=COURSE_PLACES["hidden-modes"],
                again=SecondPrediction(("controller_all",), 3, {"controller_all": (-4 - 1j, -4 + 1j, -4.5 - 3j, -4.5 + 3j)},
                ("centre", "state_parts", "input")),
    words=read_prose(Path(__file__).parent), key=("plant", "centre"), adapt=adapted,
    derived=derived, path=PATH)
