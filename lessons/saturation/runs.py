"""Runs of the clipped loop that stop where the pole has fallen: beyond that no number about them means anything."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np

from app.engine import Scenario, simulate
from app.engine.simulation import Run

from .starts import ANGLE, FAR, NEAR

FALLEN = radians(45.0)  # where the linear pole counts as fallen
PARTS = (0.5, 0.5, 1.0, 2.0, 4.0)  # s; a lost run is not followed past the part in which the pole falls
SERIES = ("x", "xhat", "e", "u_asked", "u_applied", "y", "yhat", "w", "v")


def march(scenario: Scenario) -> Run:
    """The run of a scenario, part by part, ending early with the part in which the pole falls."""
    parts: list[Run] = []
    begin, x, xhat = 0.0, scenario.x0, scenario.xhat0
    for length in PARTS:
        end = begin + length
        kicks = tuple((t - begin, jump) for t, jump in scenario.impulses
                      if begin <= t < end or end >= scenario.horizon <= t)
        part = simulate(replace(scenario, x0=x, xhat0=xhat, horizon=length, impulses=kicks))
        parts.append(part)
        begin, x, xhat = end, part.x[-1], part.xhat[-1]
        if part.diverged_at is not None or np.abs(part.x[:, ANGLE]).max() > FALLEN:
            break
    series = {name: np.concatenate([*(getattr(p, name)[:-1] for p in parts[:-1]), getattr(parts[-1], name)])
              for name in SERIES}
    count = len(series["x"])
    return Run(scenario, scenario.t[:count], **series, saturated=any(p.saturated for p in parts),
               diverged_at=None if count == scenario.n_t else scenario.dt * count)


def comes_home(run: Run) -> bool:
    """The verdict of the map for one run: near rest at the horizon and never too far from it."""
    size = np.linalg.norm(run.x, axis=1)
    return run.diverged_at is None and float(size[-1]) < NEAR and float(np.max(size)) <= FAR


def whole(run: Run) -> tuple[Run, float | None]:
    """The run over every instant of its grid, and when the pole fell, if it did.

    From the fall on everything is held. Where the estimate leaves all bounds before that, the force stays where it
    was, at its limit, and the plant goes on under it.
    """
    s, x = run.scenario, run.x
    count = s.n_t
    over = np.flatnonzero(np.abs(x[:, ANGLE]) > FALLEN)
    if run.diverged_at is not None and not len(over):
        rest = simulate(Scenario(s.plant, x0=x[-1], reference=run.u_applied[-1], dt=s.dt,
                                 horizon=s.dt * (count - len(x) + 1)))
        x = np.vstack([x, rest.x[1:]])[:count]
        over = np.flatnonzero(np.abs(x[:, ANGLE]) > FALLEN)
    end = int(over[0]) if len(over) else count - 1
    index = np.minimum(np.arange(count), min(end, len(x) - 1))
    held = {name: getattr(run, name)[np.minimum(index, len(run.t) - 1)] for name in SERIES}
    held["x"] = x[index]
    held["e"] = held["x"] - held["xhat"]
    return replace(run, t=s.t, **held), float(s.t[end]) if len(over) else None


def until(run: Run, stopped: float | None) -> Run:
    """The part of a run before the fall: where the numbers about it are taken."""
    end = len(run.t) if stopped is None else max(int(np.searchsorted(run.t, stopped)), 2)
    return replace(run, t=run.t[:end], **{name: getattr(run, name)[:end] for name in SERIES})
