"""The job: the covariance of the filter over many records of lost packets, at this loss and over all losses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from app.engine.network import intermittent_steps
from app.lesson.lesson import Design, Outcome

from .cases import SAMPLES, watched
from .runs import MOST, key

RUNS = 800
OVER = np.linspace(0.05, 0.95, 19)
FIRST = 0.2  # share of the bar for the loss of the design


@dataclass(frozen=True, eq=False)
class Trials:
    """Ratios of P[k|k−1] over RUNS records, every packet either lost or at once there.

    `mean` (SAMPLES + 1,) at the loss of the design, empty if that has changed since; `means`, `medians`: after SAMPLES
    samples for the first losses of OVER.
    """

    of: tuple[Any, ...]
    loss: float
    mean: np.ndarray
    means: tuple[float, ...] = ()
    medians: tuple[float, ...] = ()

    @property
    def done(self) -> float:
        """How far the job has come."""
        return (FIRST if len(self.mean) else 0.0) + (1 - FIRST) * len(self.means) / len(OVER)


def depends(design: Design) -> tuple[Any, ...]:
    """What the averages over all losses rest on."""
    return (*key(design), design["seed"])


def average(outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
    """Means and medians, one loss after another on the same random numbers; every yield is a place to stop."""
    d = outcome.design
    chance = np.random.default_rng([int(d["seed"]), 18]).random((RUNS, SAMPLES))
    every = 4 if watched(*key(d)).sampled.plant.n <= 2 else 1
    mean = np.empty(SAMPLES + 1)
    for k, ratios in enumerate(_ratios(d, chance >= d["loss"])):
        mean[k] = ratios.mean()
        if k % every == 0:
            yield FIRST * (k + 1) / (SAMPLES + 2), outcome
    found = Trials(depends(d), d["loss"], np.clip(mean, 1 / MOST, MOST))
    outcome = with_trials(outcome, found)
    yield FIRST, outcome
    share = (1 - FIRST) / len(OVER)
    for i, loss in enumerate(OVER):
        last, before = np.ones(RUNS), FIRST + share * i
        for k, ratios in enumerate(_ratios(d, chance >= loss)):
            last = ratios
            if k % every == 0:
                yield before + share * (k + 1) / (SAMPLES + 2), outcome
        found = replace(found, means=(*found.means, min(float(last.mean()), MOST)),
                        medians=(*found.medians, min(float(np.median(last)), MOST)))
        outcome = with_trials(outcome, found)
        yield 1.0 if i == len(OVER) - 1 else before + share, outcome


def _ratios(design: Design, heard: np.ndarray) -> Iterator[np.ndarray]:
    who = watched(*key(design))
    s = who.sampled
    for P in intermittent_steps(s.plant.A, s.plant.C, s.Q, who.R, who.steady.solution, heard):
        yield who.ratio(P)


def with_trials(outcome: Outcome, found: Trials) -> Outcome:
    """The outcome with what many runs have shown."""
    more = {"trials_done": min(found.done, 1.0)}
    if len(found.mean):
        more["trials_mean"] = float(found.mean[-1])
    return replace(outcome, study=replace(outcome.study, trials=found), metrics={**outcome.metrics, **more})


def carry(before: Outcome, after: Outcome) -> Outcome:
    """The averages go over where case, noise and seed are the same, that over time where the loss is too."""
    old, new = before.study.trials, after.study.trials
    if old is None or old.of != depends(after.design) or (new is not None and new.done >= old.done):
        return after
    if old.loss != after.design["loss"]:
        old = replace(old, mean=np.zeros(0))
    return with_trials(after, old)
