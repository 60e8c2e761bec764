"""Run the chosen filter on many seeds and collect the error at the last sample of each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.many_seeds import SeedErrors
from observer_lab.engine.filters import simulate_filters
from observer_lab.text import same, text

from .cases import PENDULUM_CASE
from .runs import FALLEN, Study, experiment_of

SAMPLES_PER_CHECK = 3  # between two looks at the mailbox


class OneGeneratorARun(np.random.Generator):
    """Normals whose last axis is the run: each column comes from its own seed, whichever other seeds run beside it."""

    def __init__(self, seeds: np.ndarray) -> None:
        super().__init__(np.random.PCG64(0))
        self._each = [np.random.default_rng([int(seed), 14]) for seed in seeds]

    def standard_normal(self, size: tuple[int, ...]) -> np.ndarray:  # type: ignore[override]
        """Normals of that shape."""
        return np.stack([rng.standard_normal(size[:-1]) for rng in self._each], axis=-1)


def run_seeds(outcome: Outcome[Study], seeds: np.ndarray) -> Iterator[tuple[float, SeedErrors | None]]:
    """The error of the filter on the stage, beside its own P, which differs from run to run. A run that the filter or the pole has
    lost counts as given up."""
    design, rng = outcome.design, OneGeneratorARun(seeds)
    count = outcome.study.case.full
    case, experiment = experiment_of(design, len(seeds), count, rng)
    rows = np.array([s.scale * np.array(s.weights) for s in case.watched])
    names = tuple(text("{name}: error [{unit}]", name=s.name, unit=same(s.unit)) for s in case.watched)
    who, down = design["filter"], np.zeros(len(seeds), dtype=bool)
    paths, sigmas = np.empty((len(seeds), count)), np.empty((len(seeds), count))
    for sample in simulate_filters(experiment, rng):
        k, beliefs = sample.k, sample.corrections[who].beliefs
        e, P = (sample.x - beliefs.mean).T, np.broadcast_to(beliefs.covariance, (len(seeds), *beliefs.covariance.shape[-2:]))
        if case.id == PENDULUM_CASE:
            down |= np.abs(sample.x[1]) > FALLEN
        paths[:, k], sigmas[:, k] = e @ rows[0], np.sqrt(np.maximum(np.einsum("i,kij,j->k", rows[0], P, rows[0]), 0.0))
        if k + 1 == count:
            errors = np.where((down | sample.lost[who])[:, None], np.nan, e)
            yield 1.0, SeedErrors(case.step * k, errors, P, rows, (names[0], names[1]), case.step * np.arange(count), paths, sigmas)
        elif k % SAMPLES_PER_CHECK == 0:
            yield (k + 1) / count, None
