"""Compare the error of many noisy runs with the Lyapunov equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from observer_lab.course.lazy import merge_lazily, replace_keeping_cache
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.text import text

from .study import Study, Trials, drawn

RUN_COUNT, BATCH_RUNS = 400, 5


def try_often(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """The job: many runs of the design on fresh noise, each error taken about its noise-free course."""
    study, scenario = outcome.study, outcome.study.run.scenario
    seeds = np.random.SeedSequence(int(outcome.design["seed"])).generate_state(RUN_COUNT)
    total = np.zeros((len(study.quiet), len(study.rows)))
    for k, seed in enumerate(seeds, start=1):
        e = drawn(replace(scenario, seed=int(seed))).e
        shared = min(len(e), len(total))
        total[:shared] += ((e[:shared] - study.quiet[:shared]) @ study.rows.T) ** 2
        if k % BATCH_RUNS == 0:
            yield k / RUN_COUNT, Trials(k, total / k)


def shown(outcome: Outcome[Study], trials: Trials) -> Outcome[Study]:
    """The outcome with what the runs showed."""
    study = replace_keeping_cache(outcome.study, trials=trials)
    more = {"trials": float(trials.count), **study.here.tried(study, trials)}
    return replace(outcome, study=study, metrics=merge_lazily(outcome.metrics, more))


def key(design: Design) -> Design:
    """What the runs rest on: all but the error that is looked at."""
    return design.with_values(watch="")


JOB = Job(text("Try {runs} runs", runs=RUN_COUNT), try_often, key, shown, figure="variance", follows=True)
