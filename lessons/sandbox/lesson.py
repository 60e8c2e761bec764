"""Sandbox: your own plant, and everything that lessons 1 to 10 ask of theirs; what cannot be asked says why."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from app.lesson.again import Again
from app.lesson.lesson import Lesson
from app.lesson.prose import read_prose
from app.plants import Model
from app.plants.examples import example
from app.plants.own import own_model, plant_of

from ..course import PLACES
from ..toolkit.tasks import fair
from .derive import derived
from .exams import EXAMS
from .figures import figures
from .job import job_on
from .knobs import knobs
from .study import compute
from .tasks import TASKS


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The sandbox for a person's plant, with the tasks that can be done on it."""
    return fair(replace(build(model), words=lesson.words))


def build(model: Model) -> Lesson:
    """The sandbox for a plant."""
    return Lesson(
        "sandbox", 19, knobs(model), partial(compute, model), partial(figures, model), answer=1, answering="lights",
        tasks=TASKS, exams=EXAMS, source="Lessons 1 to 10, with their sources; example plants in app/plants/data",
        place=PLACES["sandbox"],
        again=Again(("belief",), 1, {"belief": 1000.0}, ("nis", "gain", "lights")),
    words=read_prose(Path(__file__).parent), key=("method", "limited", "noisy"), aside=("sensor", "belief", "tolerance"), job=job_on(model),
        adapt=adapted, universal=True, derived=partial(derived))


LESSON = build(own_model(plant_of(example("aircraft"))))
