"""Compute the recovery map of lesson 7 pass by pass, and handle clicks on it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import merge_lazily
from observer_lab.course.lesson import Job, Outcome
from observer_lab.engine import Scenario
from observer_lab.engine.kernels import kernels_ready
from observer_lab.engine.simulation import simulate_recovery
from observer_lab.text import text

from ..toolkit.knobs import PULLS
from .ending import map_span
from .knobs import HORIZON
from .study import (
    ANGLE,
    LOST_NORM,
    NOT_COMPUTED,
    NOT_RECOVERED,
    RECOVERED,
    RECOVERED_NORM,
    START_GRID_DEG,
    UNRECOVERABLE,
    Starts,
    Study,
    ceiling,
    depends,
    nearest,
    scenario_of,
    slowest,
)

MAP_STEP_S = 0.01  # s, grid of the map's runs
PASS_STRIDE = 2  # the map is found in STRIDE² interlaced passes
COARSE = np.arange(
    2, len(START_GRID_DEG), 3
)  # places on the grid of the starts that a rough map runs: every third, as many on either side of zero
SLICE_S = 0.004  # s of work between two yields


def map_scenario(scenario: Scenario) -> Scenario:
    """The scenario of the map: the same loop from rest and a true estimate, without a kick, on the map's own grid."""
    rest, plant = np.zeros(scenario.plant.n), scenario.plant
    span = map_span(HORIZON, plant.A, plant.B, plant.C, scenario.K, scenario.L)
    return replace(scenario, x0=rest, xhat0=rest, impulses=(), horizon=span, dt=MAP_STEP_S)


def survey(scenario: Scenario, state: int, grid: np.ndarray, values: np.ndarray, passes: Sequence[tuple[np.ndarray, np.ndarray]],
           threshold: float, bound: float) -> Iterator[tuple[float, np.ndarray]]:
    """Yield (fraction done, map so far) every few milliseconds; each pass adds final verdicts, never guesses.

    A pass has places on the grid of starts and of errors ≥ 0 of one state. The loop is odd: (−x, −x̂) runs as the mirror image of
    (x, x̂), so the rest is mirrored. A map begun before goes on from where it was.
    """
    last = len(grid) - 1
    for k, (across, up) in enumerate(passes):
        if not len(across) or np.all(values[np.ix_(up, across)] != NOT_COMPUTED):
            continue
        recovered = np.zeros((len(across), len(up)), dtype=bool)
        for fraction, found in simulate_recovery(scenario, state, grid[across], state, grid[up], threshold=threshold, bound=bound,
                                                 slice_seconds=SLICE_S):
            recovered = found.recovered
            yield (k + fraction) / len(passes), values
        values = values.copy()
        values[np.ix_(up, across)] = np.where(recovered.T, RECOVERED, NOT_RECOVERED)
        values[np.ix_(last - up, last - across)] = values[np.ix_(up, across)]
    yield 1.0, values


def find_starts(outcome: Outcome[Study]) -> Iterator[tuple[float, Starts | None]]:
    """The map of the design's gains, limit and feed, pass by pass; it goes on from what the outcome shows of it.

    Starts beyond the ceiling need no run.
    """
    if max(slowest(outcome, name) for name in ("controller", "observer")) >= 0:
        raise KnobError(text("A pole is not in the left half plane, so no start recovers; drag it to the left first."))
    scenario = map_scenario(scenario_of(outcome.design, outcome.gains["K"], outcome.gains["L"]))
    before, n = outcome.study.starts, len(START_GRID_DEG)
    values = np.full((n, n), NOT_COMPUTED) if before is None or before.rough else before.values.copy()
    limit = ceiling(scenario.plant, float(scenario.u_max[0]))
    values[:, np.abs(START_GRID_DEG) >= limit] = UNRECOVERABLE
    angles, errors = np.flatnonzero(np.abs(START_GRID_DEG) < limit), np.flatnonzero(START_GRID_DEG >= 0)
    told: np.ndarray | None = None
    passes = [(angles[i::PASS_STRIDE], errors[j::PASS_STRIDE]) for j in range(PASS_STRIDE) for i in range(PASS_STRIDE)]
    for fraction, found in survey(scenario, ANGLE, np.radians(START_GRID_DEG), values, passes, RECOVERED_NORM, LOST_NORM):
        starts = None if found is told else Starts(found)
        told = found
        yield fraction, starts if starts is not None and starts.done > 0 else None


def rough_starts(outcome: Outcome[Study]) -> Starts | None:
    """The map from every third angle and error, at once; None where no start comes home, or where runs are not compiled."""
    if not kernels_ready() or max(slowest(outcome, name) for name in ("controller", "observer")) >= 0:
        return None
    scenario = map_scenario(scenario_of(outcome.design, outcome.gains["K"], outcome.gains["L"]))
    limit = ceiling(scenario.plant, float(scenario.u_max[0]))
    values = np.full((len(COARSE), len(COARSE)), UNRECOVERABLE)
    angles, errors = np.flatnonzero(np.abs(START_GRID_DEG[COARSE]) < limit), np.flatnonzero(START_GRID_DEG[COARSE] >= 0)
    *_, (_, found) = simulate_recovery(
        scenario,
        ANGLE,
        np.radians(START_GRID_DEG[COARSE[angles]]),
        ANGLE,
        np.radians(START_GRID_DEG[COARSE[errors]]),
        threshold=RECOVERED_NORM,
        bound=LOST_NORM,
    )
    values[np.ix_(errors, angles)] = np.where(found.recovered.T, RECOVERED, NOT_RECOVERED)
    values[np.ix_(len(COARSE) - 1 - errors, len(COARSE) - 1 - angles)] = values[np.ix_(errors, angles)]
    near = np.abs(np.arange(len(START_GRID_DEG))[:, None] - COARSE).argmin(axis=1)
    values = values[np.ix_(near, near)]
    values[:, np.abs(START_GRID_DEG) >= limit] = UNRECOVERABLE
    return Starts(values, rough=True)


def with_starts(outcome: Outcome[Study], starts: Starts) -> Outcome[Study]:
    """The outcome with the map in it; a rough one gives no numbers."""
    numbers = {} if starts.rough else {"map_done": starts.done, "map_home": starts.home}
    return replace(outcome, study=replace(outcome.study, starts=starts), metrics=merge_lazily(outcome.metrics, numbers))


def pick(outcome: Outcome[Study], x: float, y: float) -> Mapping[str, float]:
    """A click on the map: the start of the nearest cell, without a kick, so that it runs as the map says."""
    if not (np.isfinite(x) and np.isfinite(y)):
        raise KnobError(text("That click is not on the map."))
    return {"angle0": float(START_GRID_DEG[nearest(x)]), "error0": float(START_GRID_DEG[nearest(y)]), "kick": -1.0,
            **dict.fromkeys(PULLS, ())}


JOB = Job(text("Map the starts that recover"), find_starts, key=depends, shown=with_starts, figure="starts", follows=True,
          rough=rough_starts)
