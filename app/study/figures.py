"""The figure of a study: a page of surveys, one for each number that is collected."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lessons import LESSONS

from ..export.surveys import MOST, Side, Survey, surveys_as
from ..text import Text, joined, same, text
from .plan import Axis, Row, Study
from .results import Summary, shown, table

ONE = text("One run at each point.")
MANY = text("Metrics: median and 5 to 95 % of {runs} runs; checks: share that holds, with its 95 % interval.")
ONLY = text("The first {most} of {count} numbers; all of them stand in the table.")


def figure_as(study: Study, rows: Mapping[int, Row], found: Sequence[Summary], kind: str, language: str, token: str) -> bytes:
    """The page as "png", "svg" or "pdf", for a study in which at most two things vary."""
    every, sides = table(study, rows), tuple(_side(study, k, axis) for k, axis in enumerate(study.axes))
    surveys = [Survey(same(each.name), sides, each.middle, *((each.low, each.high) if study.runs > 1 else (each.middle, each.middle)),
                      every[:, k], each.is_check) for k, each in enumerate(found[:MOST])]
    return surveys_as(surveys, kind, language, _caption(study), token)


def _caption(study: Study) -> Text:
    runs = ONE if study.runs == 1 else MANY.format(runs=study.runs)
    return runs if len(study.collect) <= MOST else joined(runs, ONLY.format(most=MOST, count=len(study.collect)))


def _side(study: Study, k: int, axis: Axis) -> Side:
    values = [shown(study, k, at) for at in range(len(axis.values))]
    numbers = np.array([value for value in values if isinstance(value, float)])
    names = () if len(numbers) == len(values) else tuple(str(value)[:18] for value in values)
    return Side(_label(study, axis), numbers, axis.log and bool(np.all(numbers > 0)), names)


def _label(study: Study, axis: Axis) -> Text:
    if axis.of_plant:
        return same(axis.name)
    knob = LESSONS[study.lesson].fit(study.plant).knob(axis.name)
    return text("{label} [{unit}]", label=knob.label, unit=knob.unit) if knob.unit else knob.label
