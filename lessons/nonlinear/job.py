"""Run three filters on the whole record, many runs at once."""

from __future__ import annotations

from collections.abc import Iterator

from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.text import text

from .cases import PENDULUM_CASE, PLATFORM
from .runs import JOB_RUNS, Study, studies
from .study import outcome_of

SAMPLES_PER_CHECK = 3  # samples of the job between two looks at the mailbox


def try_often(outcome: Outcome[Study]) -> Iterator[tuple[float, Study | None]]:
    """The job: the whole record, many runs at once."""
    design, count = outcome.design, outcome.study.case.full
    for k, study in enumerate(studies(design, JOB_RUNS, count, SAMPLES_PER_CHECK), start=1):
        if study is None:
            yield min(k * SAMPLES_PER_CHECK / count, 0.99), None
        else:
            yield 1.0, study


def depends(design: Design) -> Design:
    """The design without what only changes what is looked at: the line in doubt, the bars, and the ghost where it does not steer."""
    steered = design["case"] == PENDULUM_CASE or (design["case"] == PLATFORM and design["steer"])
    return design.with_values(line="", bars="") if steered else design.with_values(line="", bars="", filter="")


def shown(outcome: Outcome[Study], found: Study) -> Outcome[Study]:
    """The same design by its many runs."""
    return outcome_of(outcome.design, found)


JOB = Job(text("Try {many} runs", many=JOB_RUNS), try_often, depends, shown, figure="nees", follows=True)
