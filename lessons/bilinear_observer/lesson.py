"""Assemble lesson 16: a functional observer of a bilinear plant in eight steps."""

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
from .knobs import KNOBS
from .own import adapted
from .path import PATH
from .study import compute
from .tasks import TASKS

LESSON = Lesson("bilinear-observer", 16, KNOBS, compute, figures, answer=2, answering="error", tasks=TASKS, exams=EXAMS,
                source="Synthesis of functional observers for bilinear plants (004), Avtometriya 53 (2017) no. 4, "
                       "equations (1)–(24) and the worked example",
                place=COURSE_PLACES["bilinear-observer"],
                again=SecondPrediction(("form",), 1, {"form": "filtered", "pole": (-60 + 0j,)}, ("forms", "error")),
    words=read_prose(Path(__file__).parent), key=("step", "input", "form"), adapt=adapted, bilinear=True,
    aside=("amplitude", "omega", "seed", "tau", "noise", "chi0", "line"), code=code,
    derived=derived, path=PATH)
