"""Fit lesson 10 to its cases: the two of the literature, or a person's own plant."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any  # a field of a lesson is `Any` until the lesson holds it

from observer_lab.course.lesson import Lesson
from observer_lab.plants.model import Model

from .cases import Case, case_of, doyle_case, report_case
from .derive import cost_split
from .knobs import knobs_for
from .study import compute_for

CASES = (report_case(), doyle_case())


def fields_on(cases: tuple[Case, ...]) -> dict[str, Any]:
    """The fields of the lesson that its cases decide."""
    return {"knobs": knobs_for(cases), "compute": partial(compute_for, cases)}


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; tasks about the two built-in cases are left out. Raises EngineError."""
    return replace(lesson, **fields_on((case_of(model),)), tasks=(), derived=cost_split)
