"""Fit the sandbox to a plant: the example that it opens with, or a person's own."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any  # a field of a lesson is `Any` until the lesson holds it

from observer_lab.course.lesson import Lesson
from observer_lab.plants import Model
from observer_lab.plants.examples import example
from observer_lab.plants.own_plant import own_model, plant_of

from ..toolkit.tasks import keep_fair_tasks
from .derive import derived
from .figures import figures
from .job import job_on
from .knobs import knobs
from .study import compute

EXAMPLE = own_model(plant_of(example("aircraft")))


def fields_on(model: Model) -> dict[str, Any]:
    """The fields of the lesson that a plant decides."""
    return {"knobs": knobs(model), "compute": partial(compute, model), "figures": partial(figures, model), "job": job_on(model),
            "derived": partial(derived)}  # one of its own for each plant: the derivation's numbers hold on all of them


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The sandbox for a person's plant, with the tasks that can be done on it."""
    return keep_fair_tasks(replace(lesson, **fields_on(model)))
