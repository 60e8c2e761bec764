"""The job: algorithm RLO in each norm inside the region, then the worst of the eight vertices along the axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from app.engine import functional_observer
from app.engine.observers import FunctionalObserver, Region, RobustObserver, rlo_steps, vertices, worst_error_gain
from app.lesson.lesson import Design, Outcome

from .loops import CASES, MOST, NORMS, ONE, deltas, weighted

WORST_CONDITION = 50.0  # of [T; C]: J does not see N, so RLO must be told how large it may grow
SWEEP = 33  # poles along the axis
SHARE = 0.25  # of the progress bar, for each norm


@dataclass(frozen=True, eq=False)
class Search:
    """What RLO found so far: results by norm, and the worst |e_u/v| over poles s (example 2: s and s − 1)."""

    key: tuple[Any, ...]
    found: tuple[tuple[str, RobustObserver], ...] = ()
    s: np.ndarray = field(default_factory=lambda: np.zeros(0))
    worst: np.ndarray = field(default_factory=lambda: np.zeros(0))
    done: float = 0.0


def depends(design: Design) -> tuple[Any, ...]:
    """What the search rests on; poles, norm, W and the start are not among it."""
    names = ("example", "alpha", "beta", "gamma", "region_low", "region_high", *CASES[design["example"]].deltas)
    return tuple(design[name] for name in names)


def search(outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
    """RLO for the norms 1, 2 and ∞, then the sweep; every yield is a place to stop."""
    design = outcome.design
    result, before = Search(depends(design)), 0.0
    example, wrong = CASES[design["example"]].example, weighted(design)
    region = Region(design["region_low"], design["region_high"])
    for name, norm in NORMS.items():
        best: RobustObserver | None = None
        for part, found in rlo_steps(example.plant, example.K, wrong=wrong, norm=norm, region=region,
                                     worst_condition=WORST_CONDITION):
            best = found
            yield before + SHARE * part, outcome
        assert best is not None
        before += SHARE
        result = replace(result, found=(*result.found, (name, best)), done=before)
        outcome = with_search(outcome, result)
        yield before, outcome
    axis = -np.geomspace(-design["region_low"], -design["region_high"], SWEEP)
    errors = vertices(example.wrong, *deltas(design))
    for k, s in enumerate(axis):
        worst = min(worst_error_gain(swept(design, float(s)), errors), MOST)
        result = replace(result, s=np.append(result.s, s), worst=np.append(result.worst, worst),
                         done=before + (1 - before) * (k + 1) / SWEEP)
        if k % 8 == 7 or k == SWEEP - 1:
            outcome = with_search(outcome, result)
        yield result.done, outcome


def swept(design: Design, s: float) -> FunctionalObserver:
    """The observer with its pole at s, or its poles at s and s − 1."""
    example = CASES[design["example"]].example
    poles = [s] if design["example"] == ONE else [s, s - 1]
    return functional_observer(example.plant, example.K, len(poles), poles=poles, wrong=weighted(design))


def with_search(outcome: Outcome, result: Search) -> Outcome:
    """The outcome with what the search knows."""
    more = {f"J_rlo_{name}": float(found.value) for name, found in result.found}
    more |= {f"s_rlo_{name}": float(np.max(found.observer.poles.real)) for name, found in result.found}
    if len(result.s):
        more |= {"least_worst": float(np.min(result.worst)), "s_least_worst": float(result.s[np.argmin(result.worst)])}
    return replace(outcome, study=replace(outcome.study, search=result),
                   metrics={**outcome.metrics, **more, "search_done": result.done})


def carry(before: Outcome, after: Outcome) -> Outcome:
    """The search goes over to the next design as long as what it rests on is the same, and if it knows more."""
    old, new = before.study.search, after.study.search
    if old is None or old.key != depends(after.design) or (new is not None and new.done >= old.done):
        return after
    return with_search(after, old)
