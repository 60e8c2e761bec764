"""Compare the error of many noisy runs with the Lyapunov equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from observer_lab.course.lazy import merge_lazily
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.engine import simulate
from observer_lab.text import text

from .knobs import POSITION
from .study import Study, Trials, scenario_of

RUN_COUNT, BATCH_RUNS = 400, 5


# --- Monte-Carlo -----------------------------------------------------------------------------------------------------
def try_often(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """The job: many runs of the design on fresh noise, each error taken about its noise-free course."""
    scenario, study = scenario_of(outcome.design, outcome.gains["L"]), outcome.study
    seeds = np.random.SeedSequence(int(outcome.design["seed"])).generate_state(RUN_COUNT)
    total = np.zeros_like(study.quiet)
    for k, seed in enumerate(seeds, start=1):
        total += (simulate(replace(scenario, seed=int(seed))).e - study.quiet) ** 2
        if k % BATCH_RUNS == 0:
            yield k / RUN_COUNT, Trials(k, total / k)


def shown(outcome: Outcome[Study], trials: Trials) -> Outcome[Study]:
    """The outcome with what the runs showed."""
    tail = trials.square[-1] / np.diagonal(outcome.study.grown[-1])
    more = {"trials": float(trials.count), "trial_ratio_position": float(tail[0]),
            "trial_ratio_velocity": float(tail[1])}
    return replace(outcome, study=replace(outcome.study, trials=trials), metrics=merge_lazily(outcome.metrics, more))


def key(design: Design) -> Design:
    """What the runs rest on: all but the error that is looked at."""
    return design.with_values(watch=POSITION)


JOB = Job(text("Try {runs} runs", runs=RUN_COUNT), try_often, key, shown, figure="variance", follows=True)
