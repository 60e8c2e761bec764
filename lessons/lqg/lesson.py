"""Assemble lesson 10: LQG is optimal on average, yet has no guaranteed margins."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose
from observer_lab.plants.model import Model

from ..course import COURSE_PLACES
from .cases import Case, case_of, doyle_case, report_case
from .code import code
from .derive import cost_split, derived
from .exams import EXAMS
from .figures import all_figures
from .job import JOB
from .knobs import knobs_for
from .path import PATH
from .study import compute_for
from .tasks import TASKS


def build(cases: tuple[Case, ...]) -> Lesson:
    """The lesson on these cases."""
    return Lesson(
        "lqg", 10, knobs_for(cases), lambda design: compute_for(cases, design), all_figures, answer=3, answering="margins",
        tasks=TASKS, exams=EXAMS,
        source="Platform report (003), chapter 5: equations (71)–(89), figures 13–16; J. C. Doyle (1978); Doyle and Stein (1979)",
        place=COURSE_PLACES["lqg"],
        again=SecondPrediction(("recovery",), 3, {"case": "doyle", "recovery": 4.0}, ("price", "cost", "loop-gain")),
    words=read_prose(Path(__file__).parent), key=("case", "beta_r", "sigma", "gain"), aside=("alpha_r", "sensor", "cut", "filter", "rule"),
        job=JOB, code=code)


def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    return replace(on_model(model), words=lesson.words, derived=cost_split)


def on_model(model: Model) -> Lesson:
    """The lesson on a model of its own; tasks about the two built-in cases are left out. Raises EngineError."""
    return replace(build((case_of(model),)), tasks=())


LESSON = replace(build((report_case(), doyle_case())), adapt=adapt, derived=derived, path=PATH)
