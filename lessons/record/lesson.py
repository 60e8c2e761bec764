"""Record: from a recording to an observer, and the part of the recording that judges it."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose

from ..course import COURSE_PLACES
from .code import code
from .derive import derived
from .exams import EXAMS
from .figures import all_figures
from .knobs import KNOBS
from .path import PATH
from .study import compute, from_knobs
from .tasks import TASKS

LESSON = Lesson(
    "record",
    21,
    KNOBS,
    partial(compute, from_knobs),
    all_figures,
    answer=1,
    answering="values",
    tasks=TASKS,
    exams=EXAMS,
    source="Box and Jenkins (1970), series J; Verhaegen (1994); Schweppe (1965); Rauch, Tung and Striebel (1965)",
    place=COURSE_PLACES["record"],
    again=SecondPrediction(("factor",), 2, {"factor": 100.0}, ("nis", "innovations", "whiteness"), numbers=True),
    words=read_prose(Path(__file__).parent),
    kick=False,
    key=("data", "order", "factor"),
    aside=("share",),
    code=code,
    derived=derived,
    path=PATH,
)
