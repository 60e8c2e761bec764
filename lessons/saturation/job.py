"""Compute the recovery map of lesson 7 pass by pass, and handle clicks on it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import merge_lazily
from observer_lab.course.lesson import Job, Outcome
from observer_lab.engine import Scenario
from observer_lab.engine.kernels import kernels_ready
from observer_lab.engine.simulation import simulate_recovery
from observer_lab.text import text

from .ending import map_span
from .study import (
    CART,
    LOST_NORM,
    NOT_COMPUTED,
    NOT_RECOVERED,
    RECOVERED,
    RECOVERED_NORM,
    START_GRID_DEG,
    UNRECOVERABLE,
    Setting,
    Starts,
    Study,
    depends,
    nearest,
    scenario_of,
    slowest,
)

PASS_STRIDE = 2  # the map is found in STRIDE² interlaced passes
COARSE = np.arange(2, len(START_GRID_DEG), 3)  # places on the grid that a rough map runs: every third, as many on either side of zero
SLICE_S = 0.004  # s of work between two yields


def map_scenario(here: Setting, scenario: Scenario) -> Scenario:
    """The scenario of the map: the same loop from rest and a true estimate, without a kick, on the map's own grid."""
    rest, plant = np.zeros(scenario.plant.n), scenario.plant
    span = map_span(scenario.horizon, plant.A, plant.B, plant.C, scenario.K, scenario.L)
    return replace(here.turned(scenario), x0=rest, xhat0=rest, impulses=(), horizon=span, dt=here.map_step)


def find_starts(here: Setting, outcome: Outcome[Study]) -> Iterator[tuple[float, Starts | None]]:
    """Yield (fraction done, map so far) every few milliseconds, None where it is as before; each pass adds final verdicts, never guesses.

    It goes on from what the outcome shows of the map. Starts beyond the ceiling need no run.
    """
    if max(slowest(outcome, name) for name in ("controller", "observer")) >= 0:
        raise KnobError(here.sayings.hopeless)
    scenario = map_scenario(here, scenario_of(here, outcome.design, outcome.gains["K"], outcome.gains["L"]))
    before, n, limit = outcome.study.starts, len(here.grid), here.ceiling(outcome.design)
    values = np.full((n, n), NOT_COMPUTED) if before is None or before.rough else before.values.copy()
    values[:, np.abs(here.grid) >= limit] = UNRECOVERABLE
    starts, errors = np.flatnonzero(np.abs(here.grid) < limit), np.flatnonzero(here.grid >= 0)
    found = Starts(values) if np.any(values != NOT_COMPUTED) else None
    passes = [(starts[i::PASS_STRIDE], errors[j::PASS_STRIDE]) for j in range(PASS_STRIDE) for i in range(PASS_STRIDE)]
    for k, (across, up) in enumerate(passes):
        if not len(across) or np.all(values[np.ix_(up, across)] != NOT_COMPUTED):
            continue
        recovered = np.zeros((len(across), len(up)), dtype=bool)
        for fraction, batch in simulate_recovery(scenario, here.state, here.places[across], here.state, here.places[up],
                                                 threshold=here.sizes[0], bound=here.sizes[1], slice_seconds=SLICE_S):
            recovered = batch.recovered
            yield (k + fraction) / len(passes), found
            found = None
        values = _filled(values.copy(), across, up, recovered)
        found = Starts(values)
    yield 1.0, found


def _filled(values: np.ndarray, across: np.ndarray, up: np.ndarray, recovered: np.ndarray) -> np.ndarray:
    """The map with the verdicts on starts and errors ≥ 0. The loop is odd: (−x, −x̂) runs as the mirror image of (x, x̂)."""
    values[np.ix_(up, across)] = np.where(recovered.T, RECOVERED, NOT_RECOVERED)
    values[np.ix_(len(values) - 1 - up, len(values) - 1 - across)] = values[np.ix_(up, across)]
    return values


def rough_starts(outcome: Outcome[Study]) -> Starts | None:
    """The cart's map from every third angle and error, at once; None where no start comes home, or where runs are not compiled."""
    if not kernels_ready() or max(slowest(outcome, name) for name in ("controller", "observer")) >= 0:
        return None
    scenario = map_scenario(CART, scenario_of(CART, outcome.design, outcome.gains["K"], outcome.gains["L"]))
    limit, grid, places = CART.ceiling(outcome.design), CART.grid[COARSE], CART.places[COARSE]
    across, up = np.flatnonzero(np.abs(grid) < limit), np.flatnonzero(grid >= 0)
    *_, (_, found) = simulate_recovery(scenario, CART.state, places[across], CART.state, places[up], threshold=RECOVERED_NORM,
                                       bound=LOST_NORM)
    near = np.abs(np.arange(len(CART.grid))[:, None] - COARSE).argmin(axis=1)
    values = _filled(np.full((len(COARSE), len(COARSE)), UNRECOVERABLE), across, up, found.recovered)[np.ix_(near, near)]
    values[:, np.abs(CART.grid) >= limit] = UNRECOVERABLE
    return Starts(values, rough=True)


def with_starts(outcome: Outcome[Study], starts: Starts) -> Outcome[Study]:
    """The outcome with the map in it; a rough one gives no numbers."""
    numbers = {} if starts.rough else {"map_done": starts.done, "map_home": starts.home}
    return replace(outcome, study=replace(outcome.study, starts=starts), metrics=merge_lazily(outcome.metrics, numbers))


def pick(here: Setting, outcome: Outcome[Study], x: float, y: float) -> Mapping[str, object]:
    """A click on the map: the start of the nearest cell, without a kick or pull, so that it runs as the map says."""
    if not (np.isfinite(x) and np.isfinite(y)):
        raise KnobError(text("That click is not on the map."))
    cell = {name: float(here.grid[nearest(value, here.grid)]) for name, value in zip(here.axes, (x, y), strict=True)}
    return {**cell, "kick": -1.0, **{grip.knob: () for grip in here.model.grips}}


def job_of(here: Setting) -> Job[Study, Starts]:
    """The map of a plant as a job."""
    return Job(text("Map the starts that recover"), partial(find_starts, here), key=depends, shown=with_starts, figure="starts",
               follows=True)


JOB = replace(job_of(CART), rough=rough_starts)
