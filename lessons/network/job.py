"""Average the filter's covariance over many loss records, at this loss and at all losses."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import replace

import numpy as np

from observer_lab.course.lazy import merge_lazily, replace_keeping_cache
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.engine.network import intermittent_steps
from observer_lab.text import text

from .cases import RUN_SAMPLES, watched
from .study import DISPLAY_LIMIT, FIRST_BAR_SHARE, OVER, Study, Trials, key

RUN_COUNT = 800


def depends(design: Design) -> Hashable:
    """What the averages over all losses rest on."""
    return (*key(design), design["seed"])


def average(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials | None]]:
    """Means and medians, one loss after another on the same random numbers; every yield is a place to stop."""
    d = outcome.design
    chance = np.random.default_rng([int(d["seed"]), 18]).random((RUN_COUNT, RUN_SAMPLES))
    every = 4 if watched(*key(d)).sampled.plant.n <= 2 else 1
    mean = np.empty(RUN_SAMPLES + 1)
    for k, ratios in enumerate(_ratios(d, chance >= d["loss"])):
        mean[k] = ratios.mean()
        if k % every == 0:
            yield FIRST_BAR_SHARE * (k + 1) / (RUN_SAMPLES + 2), None
    found = Trials(d["loss"], np.clip(mean, 1 / DISPLAY_LIMIT, DISPLAY_LIMIT))
    yield FIRST_BAR_SHARE, found
    share = (1 - FIRST_BAR_SHARE) / len(OVER)
    for i, loss in enumerate(OVER):
        last, before = np.ones(RUN_COUNT), FIRST_BAR_SHARE + share * i
        for k, ratios in enumerate(_ratios(d, chance >= loss)):
            last = ratios
            if k % every == 0:
                yield before + share * (k + 1) / (RUN_SAMPLES + 2), None
        found = replace(found, means=(*found.means, min(float(last.mean()), DISPLAY_LIMIT)),
                        medians=(*found.medians, min(float(np.median(last)), DISPLAY_LIMIT)))
        yield 1.0 if i == len(OVER) - 1 else before + share, found


def _ratios(design: Design, heard: np.ndarray) -> Iterator[np.ndarray]:
    who = watched(*key(design))
    s = who.sampled
    for P in intermittent_steps(s.plant.A, s.plant.C, s.Q, who.R, who.steady.solution, heard):
        yield who.ratio(P)


def with_trials(outcome: Outcome[Study], found: Trials) -> Outcome[Study]:
    """The outcome with what many runs have shown; the average over time only where it was made at this loss."""
    if found.loss != outcome.design["loss"]:
        found = replace(found, mean=np.zeros(0))
    more = {"trials_done": min(found.done, 1.0)}
    if len(found.mean):
        more["trials_mean"] = float(found.mean[-1])
    return replace(outcome, study=replace_keeping_cache(outcome.study, trials=found), metrics=merge_lazily(outcome.metrics, more))


JOB = Job(text("Average {runs} runs", runs=RUN_COUNT), average, depends, with_trials, figure="means", follows=True)
