"""Average NIS and NEES of the filter over many records."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.lazy import merge_lazily, replace_keeping_cache
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.engine import nees, nis
from observer_lab.text import text

from .filters import UNTESTED_SAMPLES, draw, watch
from .knobs import NONE, PREDICT, SINGLE, WHITE
from .study import Study, Trials

RUN_COUNT, BATCH_RUNS = 100, 4
VIEWS = MappingProxyType({"k": 1, "phase": PREDICT, "arithmetic": SINGLE, "line": NONE})  # knobs that change no run


# --- many runs -------------------------------------------------------------------------------------------------------
def try_often(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """The job: the same filter on many drawn runs; NIS and NEES averaged at each sample."""
    d, who = outcome.design, outcome.study.watcher
    seeds = np.random.SeedSequence(int(d["seed"])).generate_state(RUN_COUNT)
    squares = np.zeros((2, len(outcome.study.nis)))
    for count, seed in enumerate(seeds, start=1):
        what = draw(int(seed), d["noise"] != WHITE, d["force"], d["kick"])
        track = watch(who, what)
        squares[0] += nis(track.innovations, track.S).values
        squares[1] += nees(what.x, track.means[:, :6], track.covariances[:, :6, :6]).values
        if count % BATCH_RUNS == 0:
            yield count / RUN_COUNT, Trials(count, squares[0] / count, squares[1] / count)


def shown(outcome: Outcome[Study], trials: Trials) -> Outcome[Study]:
    """The outcome with what the records showed."""
    more = {"trials": float(trials.count), "trials_nis": float(trials.nis[UNTESTED_SAMPLES:].mean()),
            "trials_nees": float(trials.nees[UNTESTED_SAMPLES:].mean())}
    return replace(outcome, study=replace_keeping_cache(outcome.study, trials=trials), metrics=merge_lazily(outcome.metrics, more))


def key(design: Design) -> Design:
    """What the records rest on: all but what is looked at."""
    return design.with_values(**VIEWS)


JOB = Job(text("Try {runs} runs", runs=RUN_COUNT), try_often, key, shown, figure="nees", follows=True)
