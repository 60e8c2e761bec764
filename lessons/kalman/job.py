"""Average NIS and NEES of the filter over many records."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np

from observer_lab.course.lazy import merge_lazily, replace_keeping_cache
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.text import text

from .deck_figures import DECK_SETTING
from .knobs import NONE, PREDICT, SINGLE, STEP
from .study import S, Setting, Trials

RUN_COUNT, BATCH_RUNS = 100, 2
VIEWS = MappingProxyType({"k": 1, "phase": PREDICT, "above": STEP, "arithmetic": SINGLE, "line": NONE})  # knobs that change no run


def try_often(here: Setting[S], outcome: Outcome[S]) -> Iterator[tuple[float, Trials]]:
    """The job: the same filter on many drawn runs; NIS and NEES averaged at each sample, as far as all runs go."""
    seeds = np.random.SeedSequence(int(outcome.design["seed"])).generate_state(RUN_COUNT)
    nis, nees = np.zeros_like(outcome.study.nis), np.zeros_like(outcome.study.nees)
    for count, seed in enumerate(seeds, start=1):
        other = here.studied(outcome.design, int(seed))
        shared = min(len(nis), len(other.nis))
        nis, nees = nis[:shared] + other.nis[:shared], nees[:shared] + other.nees[:shared]
        if count % BATCH_RUNS == 0:
            yield count / RUN_COUNT, Trials(count, nis / count, nees / count)


def shown(outcome: Outcome[S], trials: Trials) -> Outcome[S]:
    """The outcome with what the records showed."""
    first = outcome.study.watcher.first
    more = {"trials": float(trials.count), "trials_nis": float(trials.nis[first:].mean()), "trials_nees": float(trials.nees[first:].mean())}
    return replace(outcome, study=replace_keeping_cache(outcome.study, trials=trials), metrics=merge_lazily(outcome.metrics, more))


def key(design: Design) -> Design:
    """What the records rest on: all but what is looked at."""
    return design.with_values(**{name: value for name, value in VIEWS.items() if name in dict(design.values)})


def job_of(here: Setting[S]) -> Job[S, Trials]:
    """The job on a plant."""
    return Job(text("Try {runs} runs", runs=RUN_COUNT), partial(try_often, here), key, shown, figure="nees", follows=True)


JOB = job_of(DECK_SETTING)
