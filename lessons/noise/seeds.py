"""Run a design on many seeds and collect the error at the end of each run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.many_seeds import SeedErrors
from observer_lab.engine import simulate
from observer_lab.text import text

from .knobs import DT
from .study import Study

BATCH_RUNS, STRIDE = 5, 5  # runs between two results, samples between two points of a course
NAMES = (text("position error [m]"), text("velocity error [m/s]"))


def run_seeds(outcome: Outcome[Study], seeds: np.ndarray) -> Iterator[tuple[float, SeedErrors | None]]:
    """The error about its course without noise, whose covariance P(t) the Lyapunov equation predicts from P(0) = 0."""
    study, scenario = outcome.study, outcome.study.run.scenario
    times = DT * np.arange(len(study.quiet))
    errors, paths = np.full((len(seeds), 2), np.nan), np.full((len(seeds), len(times[::STRIDE])), np.nan)
    sigmas = np.sqrt(np.maximum(study.grown[::STRIDE, 0, 0], 0.0))
    for k, seed in enumerate(seeds, start=1):
        e = simulate(replace(scenario, seed=int(seed))).e - study.quiet
        errors[k - 1], paths[k - 1] = e[-1], e[::STRIDE, 0]
        if k % BATCH_RUNS == 0 or k == len(seeds):
            yield k / len(seeds), SeedErrors(float(times[-1]), errors[:k].copy(), study.grown[-1], np.eye(2), NAMES, times[::STRIDE],
                                             paths[:k].copy(), sigmas)
