"""Fit lesson 9 to the user's own plant."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.knobs import Choice, Knob, Number
from observer_lab.course.lazy import replace_keeping_cache
from observer_lab.course.lesson import Design, Job, Lesson, Outcome
from observer_lab.plants import Model
from observer_lab.text import text

from ..toolkit.knobs import run_knobs
from .code import own_code
from .job import RUN_COUNT
from .knobs import PREDICT, UPDATE
from .own_figures import figures
from .own_study import LAST_SAMPLE, Study, compute, tried
from .study import Trials

BATCH_RUNS = 2


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """Beliefs, true noises in the plant's own measures, and the step to look at."""
    return (
        Number("q", "q", text("assumed Q / true Q"), low=0.01, high=100.0, default=0.05, scale="log",
               hint=text("Below 1 the filter trusts its model too much.")),
        Number("r", "r", text("assumed R / true R"), low=0.01, high=100.0, default=1.0, scale="log",
               hint=text("Below 1 the filter trusts its sensors too much.")),
        Number("w", r"\sigma_w", text("process noise, share of the natural input"), low=1e-3, high=10.0,
               default=0.1, scale="log", hint=text("How strongly an unknown input shakes the plant.")),
        Number("v", r"\sigma_v", text("sensor noise, share of the outputs"), low=1e-4, high=1.0,
               default=0.003,
               scale="log", hint=text("As a share of the outputs at the start.")),
        Number("k", "k", text("sample to look at"), low=1, high=LAST_SAMPLE, default=1, scale="integer",
               hint=text("The tab One step shows this sample.")),
        Choice("phase", "", text("the step"), default=PREDICT,
               options=((PREDICT, text("predict")), (UPDATE, text("predict and update"))),
               hint=text("Before or after the sample is taken in.")),
        *run_knobs(model.horizon),
    )


def try_often(model: Model, outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """The job: the same filter on many records; NIS and NEES averaged at each sample."""
    study, design = outcome.study, outcome.design
    sums = np.zeros((2, len(study.nis)))
    for count, seed in enumerate(np.random.SeedSequence(int(design["seed"])).generate_state(RUN_COUNT), start=1):
        other = Study(tried(model, design, int(seed)))
        shared = min(sums.shape[1], len(other.nis))
        sums = sums[:, :shared] + np.vstack([other.nis[:shared], other.nees[:shared]])
        if count % BATCH_RUNS == 0:
            yield count / RUN_COUNT, Trials(count, sums[0] / count, sums[1] / count)


def shown(outcome: Outcome[Study], trials: Trials) -> Outcome[Study]:
    """The outcome with what the records showed."""
    return replace(outcome, study=replace_keeping_cache(outcome.study, trials=trials))


def key(design: Design) -> Design:
    """What the records rest on: all but the sample that is looked at."""
    return design.with_values(k=1, phase=PREDICT)


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, where a Kalman filter for it exists; report and converter stay with the deck."""
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, model), figures=partial(figures, model), tasks=(),
                   code=own_code,
                   job=Job(text("Try {runs} runs", runs=RUN_COUNT), partial(try_often, model), key, shown, figure="nees", follows=True))
