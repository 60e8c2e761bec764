"""Filter many seeds of one design and collect the error at the last sample of each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.many_seeds import SeedErrors
from observer_lab.text import text

from .filters import draw, watch
from .knobs import DT, SAMPLE_COUNT, WHITE
from .study import Study

BATCH_RUNS, STRIDE = 5, 5  # runs between two results, samples between two points of a course
HEIGHT, SPEED = 1, 4  # the states that are drawn
NAMES = (text("height error [mm]"), text("vertical speed error [mm/s]"))


def run_seeds(outcome: Outcome[Study], seeds: np.ndarray) -> Iterator[tuple[float, SeedErrors | None]]:
    """The error of all six states at the last sample, beside the filter's own P there. The start is drawn anew, too."""
    d, who = outcome.design, outcome.study.watcher
    times = DT * np.arange(SAMPLE_COUNT)
    rows = 1e3 * np.eye(6)[[HEIGHT, SPEED]]
    errors, paths = np.full((len(seeds), 6), np.nan), np.full((len(seeds), len(times[::STRIDE])), np.nan)
    P = who.schedule.posterior[who.schedule.index][:, :6, :6]
    sigmas = 1e3 * np.sqrt(P[::STRIDE, HEIGHT, HEIGHT])
    for k, seed in enumerate(seeds, start=1):
        what = draw(int(seed), d["noise"] != WHITE, d["force"], d["kick"])
        e = what.x - watch(who, what).means[:, :6]
        errors[k - 1], paths[k - 1] = e[-1], 1e3 * e[::STRIDE, HEIGHT]
        if k % BATCH_RUNS == 0 or k == len(seeds):
            yield k / len(seeds), SeedErrors(float(times[-1]), errors[:k].copy(), P[-1], rows, NAMES, times[::STRIDE], paths[:k].copy(),
                                             sigmas)
