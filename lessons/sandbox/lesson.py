"""Assemble lesson 19: all analyses of lessons 1 to 10 on the user's own plant."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from observer_lab.course.exercises.second_prediction import SecondPrediction
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_prose
from observer_lab.plants import Model
from observer_lab.plants.examples import example
from observer_lab.plants.own_plant import own_model, plant_of

from ..course import COURSE_PLACES
from ..toolkit.tasks import keep_fair_tasks
from .derive import derived
from .exams import EXAMS
from .figures import figures
from .job import job_on
from .knobs import knobs
from .path import PATH
from .study import compute
from .tasks import TASKS


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The sandbox for a person's plant, with the tasks that can be done on it."""
    return keep_fair_tasks(replace(build(model), words=lesson.words))


def build(model: Model) -> Lesson:
    """The sandbox for a plant."""
    return Lesson(
        "sandbox", 19, knobs(model), partial(compute, model), partial(figures, model), answer=1, answering="lights",
        tasks=TASKS, exams=EXAMS, source="Lessons 1 to 10, with their sources; example plants in app/plants/data",
        place=COURSE_PLACES["sandbox"],
        again=SecondPrediction(("belief",), 1, {"belief": 1000.0}, ("nis", "gain", "lights")),
    words=read_prose(Path(__file__).parent), key=("method", "limited", "noisy"), aside=("r", "v", "sensor", "belief", "tolerance"),
        job=job_on(model),
        adapt=adapted, universal=True, derived=partial(derived), path=PATH)


LESSON = build(own_model(plant_of(example("aircraft"))))
