"""The job of lesson 20: the same observer slower and faster; how soon each finds the load, and what it says wrongly for that."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import replace

import numpy as np

from app.lesson.knobs import KnobError
from app.lesson.lesson import Design, Job, Outcome
from app.text import text

from .study import Study, Tried, measured
from .system import gains, played

SPEEDS = tuple(float(s) for s in np.geomspace(0.4, 4.0, 11))  # times the poles of the design


def try_speeds(outcome: Outcome[Study]) -> Iterator[tuple[float, tuple[Tried, ...]]]:
    """Scale all observer poles alike; the rest of the design stays."""
    design = outcome.design
    if not design["load_state"] or not design["load"]:
        raise KnobError(text("Finding takes a load, and an observer with a state for it."))
    if outcome.metrics["slowest_observer"] >= 0 or outcome.metrics["slowest_controller"] >= 0:
        raise KnobError(text("A pole is not in the left half plane, so nothing is found; drag it to the left first."))
    tried: list[Tried] = []
    for k, speed in enumerate(SPEEDS, start=1):
        quick = design.with_values(observer_poles=tuple(speed * q for q in design["observer_poles"]))
        tried.append(measured(speed, played(quick, *gains(quick)).run))
        yield k / len(SPEEDS), tuple(tried)


def shown(outcome: Outcome[Study], tried: tuple[Tried, ...]) -> Outcome[Study]:
    """The outcome with what the speeds came to."""
    return replace(outcome, study=replace(outcome.study, tried=tried))


def key(design: Design) -> Hashable:
    """What the speeds rest on: the whole design."""
    return design.values


JOB = Job(text("Try slower and faster observers"), try_speeds, key, shown, figure="speeds", follows=True)
