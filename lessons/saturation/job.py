"""The job of lesson 7: which pairs of angle and estimation error come home, found pass by pass, and a click on their map."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from app.engine import Scenario
from app.engine.kernels import ready
from app.engine.simulation import simulate_recovery
from app.lesson.knobs import KnobError
from app.lesson.later import with_more
from app.lesson.lesson import Job, Outcome
from app.text import text

from .knobs import HORIZON
from .study import (
    ANGLE,
    FAR,
    GRID,
    HOME,
    HOPELESS,
    LOST,
    NEAR,
    UNKNOWN,
    Starts,
    Study,
    ceiling,
    depends,
    nearest,
    scenario_of,
    slowest,
)

STEP = 0.01  # s, grid of the map's runs
STRIDE = 2  # the map is found in STRIDE² interlaced passes
COARSE = np.arange(2, len(GRID), 3)  # places on the grid of the starts that a rough map runs: every third, as many on either side of zero
SLICE = 0.004  # s of work between two yields


def map_scenario(scenario: Scenario) -> Scenario:
    """The scenario of the map: the same loop from rest and a true estimate, without a kick, on the map's own grid."""
    rest = np.zeros(scenario.plant.n)
    return replace(scenario, x0=rest, xhat0=rest, impulses=(), horizon=HORIZON, dt=STEP)


def survey(scenario: Scenario, known: Starts | None) -> Iterator[tuple[float, Starts]]:
    """Yield (fraction done, starts so far) every few milliseconds; each pass adds final verdicts, never guesses.

    The loop is odd: (−x, −x̂) runs as the mirror image of (x, x̂). So only errors ≥ 0 are run and the rest is
    mirrored, and starts beyond the ceiling need no run. A map begun before goes on from where it was.
    """
    values = np.full((len(GRID), len(GRID)), UNKNOWN) if known is None else known.values.copy()
    limit = ceiling(scenario.plant, float(scenario.u_max[0]))
    values[:, np.abs(GRID) >= limit] = HOPELESS
    angles, errors = np.flatnonzero(np.abs(GRID) < limit), np.flatnonzero(GRID >= 0)
    passes = [(angles[i::STRIDE], errors[j::STRIDE]) for j in range(STRIDE) for i in range(STRIDE)]
    starts = Starts(values)
    for k, (across, up) in enumerate(passes):
        if not len(across) or np.all(values[np.ix_(up, across)] != UNKNOWN):
            continue
        recovered = np.zeros((len(across), len(up)), dtype=bool)
        for fraction, found in simulate_recovery(scenario, ANGLE, np.radians(GRID[across]), ANGLE, np.radians(GRID[up]),
                                            threshold=NEAR, bound=FAR, slice_seconds=SLICE):
            recovered = found.recovered
            yield (k + fraction) / len(passes), starts
        values = values.copy()
        values[np.ix_(up, across)] = np.where(recovered.T, HOME, LOST)
        values[np.ix_(len(GRID) - 1 - up, len(GRID) - 1 - across)] = values[np.ix_(up, across)]
        starts = replace(starts, values=values)
    yield 1.0, starts


def find_starts(outcome: Outcome[Study]) -> Iterator[tuple[float, Starts | None]]:
    """The map of the design's gains, limit and feed, pass by pass; it goes on from what the outcome shows of it."""
    if max(slowest(outcome, name) for name in ("controller", "observer")) >= 0:
        raise KnobError(text("A pole is not in the left half plane, so no start comes home; drag it to the left "
                             "first."))
    scenario = map_scenario(scenario_of(outcome.design, outcome.gains["K"], outcome.gains["L"]))
    before = outcome.study.starts
    for fraction, starts in survey(scenario, None if before is None or before.rough else before):
        yield fraction, starts if starts.done > 0 else None


def rough_starts(outcome: Outcome[Study]) -> Starts | None:
    """The map from every third angle and error, at once; None where no start comes home, or where runs are not compiled."""
    if not ready() or max(slowest(outcome, name) for name in ("controller", "observer")) >= 0:
        return None
    scenario = map_scenario(scenario_of(outcome.design, outcome.gains["K"], outcome.gains["L"]))
    limit = ceiling(scenario.plant, float(scenario.u_max[0]))
    values = np.full((len(COARSE), len(COARSE)), HOPELESS)
    angles, errors = np.flatnonzero(np.abs(GRID[COARSE]) < limit), np.flatnonzero(GRID[COARSE] >= 0)
    *_, (_, found) = simulate_recovery(scenario, ANGLE, np.radians(GRID[COARSE[angles]]), ANGLE, np.radians(GRID[COARSE[errors]]),
                                       threshold=NEAR, bound=FAR)
    values[np.ix_(errors, angles)] = np.where(found.recovered.T, HOME, LOST)
    values[np.ix_(len(COARSE) - 1 - errors, len(COARSE) - 1 - angles)] = values[np.ix_(errors, angles)]
    near = np.abs(np.arange(len(GRID))[:, None] - COARSE).argmin(axis=1)
    values = values[np.ix_(near, near)]
    values[:, np.abs(GRID) >= limit] = HOPELESS
    return Starts(values, rough=True)


def with_starts(outcome: Outcome[Study], starts: Starts) -> Outcome[Study]:
    """The outcome with the map in it; a rough one gives no numbers."""
    numbers = {} if starts.rough else {"map_done": starts.done, "map_home": starts.home}
    return replace(outcome, study=replace(outcome.study, starts=starts), metrics=with_more(outcome.metrics, numbers))


def pick(outcome: Outcome[Study], x: float, y: float) -> Mapping[str, float]:
    """A click on the map: the start of the nearest cell, without a kick, so that it runs as the map says."""
    if not (np.isfinite(x) and np.isfinite(y)):
        raise KnobError(text("That click is not on the map."))
    return {"angle0": float(GRID[nearest(x)]), "error0": float(GRID[nearest(y)]), "kick": -1.0}


JOB = Job(text("Map the starts that come home"), find_starts, key=depends, shown=with_starts, figure="starts", follows=True,
          rough=rough_starts)
