"""Simulate the sampled loop many times and compare Welch spectra with the prediction."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import merge_lazily, replace_keeping_cache
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.engine import Belief, EngineError, Plant, chi2_band, noisy_loop, psd
from observer_lab.engine.feedback import NoisyLoop
from observer_lab.engine.sampled import SampledLqg
from observer_lab.engine.systems import root, step_covariance
from observer_lab.text import text

from .cases import Case
from .knobs import NONE, RECURSIVE
from .loops import Setting, computer, setting_of
from .study import Study, Trials

RECORDS = 12
STEPS_PER_CHECK = 400  # steps of the warm-up between two looks at cancel
SEGMENTS = 4  # a segment is this part of a record
EFFECTIVE = 5.6  # independent segments of a record with Hann windows that overlap by half, of 7 in all


@dataclass(frozen=True, eq=False)
class Bench:
    """The computer's loop: true plant and noise, sampled."""

    case: Case
    sampled: SampledLqg
    truth: Plant
    process: np.ndarray
    readings: np.ndarray
    loop: NoisyLoop


def bench_of(case: Case, setting: Setting) -> Bench:
    """The loop on a computer. Raises KnobError where it is unstable."""
    f = setting.factors
    sampled = computer(case, f, setting.recovery, case.computer)
    s = sampled.plant
    truth = Plant(s.A, setting.gain * s.B, s.C, s.D, s.dt)
    process = step_covariance(case.plant.A, case.true_disturbance(f) * case.G @ case.W @ case.G.T, s.dt)
    readings = f.sensor * case.V / s.dt
    loop = noisy_loop(truth, sampled.controller, np.eye(s.n), process, V=readings).watching(case.rows)
    if not loop.stable:
        raise KnobError(text("This loop is unstable on a computer, so it has no spectrum to measure; bring the "
                             "gain m back to 1."))
    return Bench(case, sampled, truth, process, readings, loop)


def try_often(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials | None]]:
    """The job: warm up if the filter is recursive, then one record after another."""
    design, case = outcome.design, outcome.study.case
    bench = bench_of(case, setting_of(case, design))
    rng = np.random.default_rng([int(design["seed"]), 10])
    if design["filter"] == RECURSIVE:
        starts, share = np.empty((0, 0)), 0.4
        for done, ends in _warm_up(bench, rng):
            starts = ends
            yield share * done, None
    else:
        starts, share = _stationary(bench, rng), 0.0
    total, predicted = 0.0, bench.loop.psd(case.frequency)
    for k, z in enumerate(starts, start=1):
        total = total + _record(bench, z, int(rng.integers(2**31)))  # type: ignore[operator]
        yield share + (1 - share) * k / len(starts), _trials(bench, k, total / k, predicted)


def _stationary(bench: Bench, rng: np.random.Generator) -> np.ndarray:
    """Starts of (x, x̂⁻) from the loop's own distribution, (RECORDS, 2n)."""
    S = bench.loop.covariance
    return rng.standard_normal((RECORDS, len(S))) @ root(S).T


def _warm_up(bench: Bench, rng: np.random.Generator) -> Iterator[tuple[float, np.ndarray]]:
    """All records together through the time in which the recursive filter's gain still changes."""
    s, case, kf = bench.sampled.plant, bench.case, bench.sampled.filter
    n, steps = s.n, round(case.warm_up / s.dt)
    P = case.open_loop.covariance if case.open_loop.stable else np.diag(np.square(case.model.x0))
    P = P + 1e-9 * np.trace(P) / n * np.eye(n)
    z = np.hstack([rng.standard_normal((RECORDS, n)) @ root(P).T, np.zeros((RECORDS, n))])
    belief, to_w, to_v = Belief(np.zeros(n), P), root(bench.process), root(bench.readings)
    for first in range(0, steps, STEPS_PER_CHECK):
        plan = kf.schedule(belief, min(STEPS_PER_CHECK, steps - first))
        for k in plan.index:
            M = plan.gains[k]
            x, predicted = z[:, :n], z[:, n:]
            y = x @ s.C.T + rng.standard_normal((RECORDS, s.p)) @ to_v.T
            u = -(predicted + (y - predicted @ s.C.T) @ M.T)
            xhat, u = -u, u @ bench.sampled.K.T
            z = np.hstack([x @ s.A.T + u @ bench.truth.B.T + rng.standard_normal((RECORDS, n)) @ to_w.T,
                           xhat @ s.A.T + u @ s.B.T])
        belief = kf.predict(Belief(np.zeros(n), plan.posterior[-1]))
        if not np.isfinite(z).all():
            raise EngineError("The run left every scale while the recursive filter settled; bring the gain m "
                              "nearer to 1.")
        yield (first + len(plan.index)) / steps, z


def _record(bench: Bench, z: np.ndarray, seed: int) -> np.ndarray:
    """Welch's density of the channels of one run with the steady gain, at the case's frequencies."""
    s, case = bench.sampled, bench.case
    n, steps = s.plant.n, round(case.record / s.plant.dt)
    run = s.run(z[:n], *s.draw(steps, seed, process=bench.process, readings=bench.readings), xhat0=z[n:], truth=bench.truth)
    seen = psd(run.x @ case.rows.T, 1 / s.plant.dt, segment=steps // SEGMENTS)
    return np.column_stack([np.interp(case.frequency, seen.frequency, column) for column in seen.density.T])


def _trials(bench: Bench, count: int, density: np.ndarray, predicted: np.ndarray) -> Trials:
    f, lowest = bench.case.frequency, 8 * SEGMENTS / bench.case.record
    judged = (f > lowest) & (f < 0.25 / bench.sampled.plant.dt)
    ratio = density[judged] / np.maximum(predicted[judged], 1e-300)
    freedom = round(2 * EFFECTIVE * count)
    low, high = chi2_band(freedom)
    band = (low / freedom, high / freedom)
    return Trials(count, density, predicted, band, ratio.mean(axis=0), ((ratio > band[0]) & (ratio < band[1])).mean(axis=0))


def shown(outcome: Outcome[Study], trials: Trials) -> Outcome[Study]:
    """The outcome with what the runs showed."""
    more = {"trials": float(trials.count),
            **{f"trial_ratio_{i}": float(r) for i, r in enumerate(trials.ratio)},
            **{f"trial_inside_{i}": float(r) for i, r in enumerate(trials.inside)}}
    return replace(outcome, study=replace_keeping_cache(outcome.study, trials=trials), metrics=merge_lazily(outcome.metrics, more))


VIEWS = MappingProxyType({"rule": NONE, "cut": "1", "kick": -1.0})  # knobs that change no spectrum


def key(design: Design) -> Design:
    """What the runs rest on: all but what is looked at."""
    return design.with_values(**VIEWS)


JOB = Job(text("Run it {records} times on a computer", records=RECORDS), try_often, key, shown, figure="spectrum0", follows=True)
