"""Run the controller on the stage with many seeds and collect the velocities at the end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Outcome
from observer_lab.course.many_seeds import SeedErrors
from observer_lab.engine import simulate_trial
from observer_lab.engine.sampled import thin_root
from observer_lab.text import text

from .controllers import DT, ORDER
from .simulation import loop_of
from .study import Study

RUN_SAMPLES, STRIDE = 1001, 20  # samples of a run, and between two points of a course
MICRO = 1e6  # µm/s in a metre per second
NAMES = (text("vertical velocity [µm/s]"), text("rotation velocity [µm/s]"))
UNSTABLE = text("This loop is unstable, so its velocities have no covariance; choose a controller that holds the platform.")


def run_seeds(outcome: Outcome[Study], seeds: np.ndarray) -> Iterator[tuple[float, SeedErrors | None]]:
    """Velocities of the three channels, which control should hold at zero, beside their covariance as the Lyapunov equation of the whole
    loop predicts it. Each run starts from that covariance; a converter and a limit of the coils are in the runs as they are.
    Raises KnobError for an unstable loop.
    """
    m = outcome.study
    loop = loop_of(m.world, m.five[ORDER.index(outcome.design["play"])])
    if not loop.stable:
        raise KnobError(UNSTABLE)
    outputs = loop.outputs[:3]
    start, P = thin_root(loop.covariance), outputs @ loop.covariance @ outputs.T
    times = DT * np.arange(0, RUN_SAMPLES, STRIDE)
    rows, sigmas = MICRO * np.eye(3)[:2], np.full(len(times), MICRO * np.sqrt(P[0, 0]))
    errors, paths = np.full((len(seeds), 3), np.nan), np.full((len(seeds), len(times)), np.nan)
    for k, seed in enumerate(seeds, start=1):
        drawn = np.random.default_rng([int(seed), 13]).standard_normal(start.shape[1])
        run = simulate_trial(loop, RUN_SAMPLES, seed=int(seed), start=start @ drawn)
        if not run.diverged:
            v = run.outputs[:, :3]
            errors[k - 1], paths[k - 1] = v[-1], MICRO * v[::STRIDE, 0]
        yield k / len(seeds), SeedErrors(float(times[-1]), errors[:k].copy(), P, rows, NAMES, times, paths[:k].copy(), sigmas)
