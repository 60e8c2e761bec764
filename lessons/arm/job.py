"""Compare slower and faster observers: time to find the load, and error at standstill."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import replace

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.text import text

from .loop import gains, played
from .study import Study, Tried, measured

POLE_FACTORS = tuple(float(s) for s in np.geomspace(0.4, 4.0, 11))  # times the poles of the design


def try_speeds(outcome: Outcome[Study]) -> Iterator[tuple[float, tuple[Tried, ...]]]:
    """Scale all observer poles alike; the rest of the design stays."""
    design = outcome.design
    if not design["load_state"] or not design["load"]:
        raise KnobError(text("Finding takes a load, and an observer with a state for it."))
    if outcome.metrics["slowest_observer"] >= 0 or outcome.metrics["slowest_controller"] >= 0:
        raise KnobError(text("A pole is not in the left half plane, so nothing is found; drag it to the left first."))
    tried: list[Tried] = []
    for k, speed in enumerate(POLE_FACTORS, start=1):
        quick = design.with_values(observer_poles=tuple(speed * q for q in design["observer_poles"]))
        tried.append(measured(speed, played(quick, *gains(quick)).run))
        yield k / len(POLE_FACTORS), tuple(tried)


def shown(outcome: Outcome[Study], tried: tuple[Tried, ...]) -> Outcome[Study]:
    """The outcome with what the speeds came to."""
    return replace(outcome, study=replace(outcome.study, tried=tried))


def key(design: Design) -> Hashable:
    """What the speeds rest on: the whole design."""
    return design.values


JOB = Job(text("Try slower and faster observers"), try_speeds, key, shown, figure="speeds", follows=True)
