"""Run algorithm RLO in each norm, then the worst of eight vertices along the axis."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import replace

import numpy as np

from observer_lab.course.lazy import merge_lazily
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.engine import functional_observer
from observer_lab.engine.observers import FunctionalObserver, Region, RobustObserver, rlo_steps, vertices, worst_error_gain
from observer_lab.text import text

from .knobs import EXAMPLE_FOUR, EXAMPLE_ONE, EXAMPLE_THREE, NORMS
from .rectangle import best_in_rectangle
from .study import DISPLAY_LIMIT, EXAMPLE_CASES, Search, Story, deltas, observer_of, weighted

WORST_CONDITION = 50.0  # of [T; C]: J does not see N, so RLO must be told how large it may grow
SWEEP = 33  # poles along the axis
NORM_PROGRESS_SHARE = 0.25  # of the progress bar, for each norm


def key(design: Design) -> Hashable:
    """What the search rests on; poles, norm, W and the start are not among it."""
    names = ("example", "free", "alpha", "second", "beta", "gamma", "region_low", "region_high", *EXAMPLE_CASES[design["example"]].deltas,
             *(("region_tall",) if design["example"] == EXAMPLE_FOUR else ()))
    return tuple(design[name] for name in names)


def search(outcome: Outcome[Story]) -> Iterator[tuple[float, Search | None]]:
    """RLO for the norms 1, 2 and ∞, then the sweep; every yield is a place to stop."""
    design = outcome.design
    result, before = Search(), 0.0
    example, wrong = EXAMPLE_CASES[design["example"]].example, weighted(design)
    region = Region(design["region_low"], design["region_high"])
    for name, norm in NORMS.items():
        best: RobustObserver | None = None
        steps = (best_in_rectangle(design, name, WORST_CONDITION) if design["example"] == EXAMPLE_FOUR else
                 rlo_steps(example.plant, example.K, wrong=wrong, norm=norm, region=region, worst_condition=WORST_CONDITION))
        for part, found in steps:
            best = found
            yield before + NORM_PROGRESS_SHARE * part, None
        assert best is not None
        before += NORM_PROGRESS_SHARE
        result = replace(result, found=(*result.found, (name, best)), done=before)
        yield before, result
    axis = -np.geomspace(-design["region_low"], -design["region_high"], SWEEP)
    errors = vertices(example.wrong, *deltas(design))
    for k, s in enumerate(axis):
        worst = min(worst_error_gain(swept(design, float(s)), errors), DISPLAY_LIMIT)
        result = replace(result, s=np.append(result.s, s), worst=np.append(result.worst, worst),
                         done=before + (1 - before) * (k + 1) / SWEEP)
        yield result.done, result if k % 8 == 7 or k == SWEEP - 1 else None


def swept(design: Design, s: float) -> FunctionalObserver:
    """The observer with its pole at s, or its poles at s and s − 1."""
    case = EXAMPLE_CASES[design["example"]]
    poles = (complex(s),) if design["example"] == EXAMPLE_ONE else (complex(s), complex(s - 1))
    if design["example"] in (EXAMPLE_THREE, EXAMPLE_FOUR):
        return observer_of(design.with_values(**{case.poles: poles}))
    return functional_observer(case.example.plant, case.example.K, len(poles), poles=poles, wrong=weighted(design))


def shown(outcome: Outcome[Story], result: Search) -> Outcome[Story]:
    """The outcome with what the search knows."""
    more = {f"J_rlo_{name}": float(found.value) for name, found in result.found}
    more |= {f"s_rlo_{name}": float(np.max(found.observer.poles.real)) for name, found in result.found}
    more |= {f"im_rlo_{name}": float(np.max(found.observer.poles.imag)) for name, found in result.found}
    if len(result.s):
        more |= {"least_worst": float(np.min(result.worst)), "s_least_worst": float(result.s[np.argmin(result.worst)])}
    more["search_done"] = result.done
    return replace(outcome, study=replace(outcome.study, search=result), metrics=merge_lazily(outcome.metrics, more))


JOB = Job(text("Run algorithm RLO"), search, key, shown, figure="found")
