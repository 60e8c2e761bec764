"""Draw a study's figure: one plot for each collected number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from observer_lab.lessons import LESSONS

from ..export.figures.study_plots import MAX_SURVEYS, PlotAxis, StudyPlot, save_study_plots
from ..text import Text, joined, same, text
from .plan import Axis, Row, Study
from .results import Summary, shown, table

ONE_RUN_CAPTION = text("One run at each point.")
MANY_RUNS_CAPTION = text("Metrics: median and 5 to 95 % of {runs} runs; checks: share that holds, with its 95 % interval.")
ONLY = text("The first {most} of {count} numbers; all of them stand in the table.")


def figure_as(study: Study, rows: Mapping[int, Row], found: Sequence[Summary], kind: str, language: str, token: str) -> bytes:
    """The page as "png", "svg" or "pdf", for a study in which at most two things vary."""
    every, sides = table(study, rows), tuple(_side(study, k, axis) for k, axis in enumerate(study.axes))
    surveys = [StudyPlot(same(each.name), sides, each.middle, *((each.low, each.high) if study.runs > 1 else (each.middle, each.middle)),
                      every[:, k], each.is_check) for k, each in enumerate(found[:MAX_SURVEYS])]
    return save_study_plots(surveys, kind, language, _caption(study), token)


def _caption(study: Study) -> Text:
    runs = ONE_RUN_CAPTION if study.runs == 1 else MANY_RUNS_CAPTION.format(runs=study.runs)
    return runs if len(study.collect) <= MAX_SURVEYS else joined(runs, ONLY.format(most=MAX_SURVEYS, count=len(study.collect)))


def _side(study: Study, k: int, axis: Axis) -> PlotAxis:
    values = [shown(study, k, at) for at in range(len(axis.values))]
    numbers = np.array([value for value in values if isinstance(value, float)])
    names = () if len(numbers) == len(values) else tuple(str(value)[:18] for value in values)
    return PlotAxis(_label(study, axis), numbers, axis.log and bool(np.all(numbers > 0)), names)


def _label(study: Study, axis: Axis) -> Text:
    if axis.of_plant:
        return same(axis.name)
    knob = LESSONS[study.lesson].fit(study.plant).knob(axis.name)
    return text("{label} [{unit}]", label=knob.label, unit=knob.unit) if knob.unit else knob.label
