"""The job: many runs on fresh noise beside what the Lyapunov equation promises."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from app.engine import simulate
from app.lesson.later import with_more
from app.lesson.lesson import Design, Job, Outcome
from app.text import text

from .knobs import POSITION
from .study import Study, Trials, scenario_of

RUNS, AT_ONCE = 400, 5


# --- Monte-Carlo -----------------------------------------------------------------------------------------------------
def try_often(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """The job: many runs of the design on fresh noise, each error taken about its noise-free course."""
    scenario, study = scenario_of(outcome.design, outcome.gains["L"]), outcome.study
    seeds = np.random.SeedSequence(int(outcome.design["seed"])).generate_state(RUNS)
    total = np.zeros_like(study.quiet)
    for k, seed in enumerate(seeds, start=1):
        total += (simulate(replace(scenario, seed=int(seed))).e - study.quiet) ** 2
        if k % AT_ONCE == 0:
            yield k / RUNS, Trials(k, total / k)


def shown(outcome: Outcome[Study], trials: Trials) -> Outcome[Study]:
    """The outcome with what the runs showed."""
    tail = trials.square[-1] / np.diagonal(outcome.study.grown[-1])
    more = {"trials": float(trials.count), "trial_ratio_position": float(tail[0]),
            "trial_ratio_velocity": float(tail[1])}
    return replace(outcome, study=replace(outcome.study, trials=trials), metrics=with_more(outcome.metrics, more))


def key(design: Design) -> Design:
    """What the runs rest on: all but the error that is looked at."""
    return design.with_values(watch=POSITION)


JOB = Job(text("Try {runs} runs", runs=RUNS), try_often, key, shown, figure="variance", follows=True)
