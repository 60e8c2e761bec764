"""Run algorithm RLO on an own plant and compare with the chosen observer."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import merge_lazily
from observer_lab.course.lesson import Design, Outcome
from observer_lab.engine import EngineError
from observer_lab.engine.observers import Region, RobustObserver, rlo_steps
from observer_lab.engine.systems import Poles
from observer_lab.text import text

from .knobs import NORMS
from .loop import Run, Setting, run_of
from .loop import Story as PlainStory
from .own_plant import WORST_CONDITION, Here, met

NUDGES = (1e-6, 1e-5, 1e-4, 1e-3)


@dataclass(frozen=True, eq=False)
class Story(PlainStory):
    """With what RLO found and its run on the true plant, if it has run."""

    found: RobustObserver | None = None
    found_run: Run | None = None


def key(design: Design) -> Hashable:
    """What the search rests on: neither the order nor the poles nor the errors of the plant."""
    names = ("wanted", "controller_poles", "norm", "alpha", "beta", "gamma", "region_low", "region_high", "region_tall")
    return tuple(design[name] for name in names)


def inside(poles: Poles, design: Design) -> bool:
    """Whether all poles lie in the region of RLO."""
    return bool(np.all((poles.real >= design["region_low"]) & (poles.real <= design["region_high"])
                       & (np.abs(poles.imag) <= design["region_tall"])))


def search(here: Here, outcome: Outcome[Story]) -> Iterator[tuple[float, RobustObserver | None]]:
    """Algorithm RLO for this plant; a better observer of the same order that is already chosen stays the result."""
    design, chosen = outcome.design, outcome.study.observer
    units, row, result = here.scaled, here.rows(design)[1], None
    region = Region(design["region_low"] / units.rate, design["region_high"] / units.rate, 0.0, design["region_tall"] / units.rate)
    try:
        for part, found in rlo_steps(units.inner, row * units.unit, wrong=units.within(here.weighed(design)),
                                     norm=NORMS[design["norm"]], region=region,
                                     max_order=here.highest, worst_condition=WORST_CONDITION):
            result = found
            yield 0.99 * part, None
    except (EngineError, np.linalg.LinAlgError) as problem:
        raise KnobError(text("Algorithm RLO finds no observer in this region whose [T; C] has a condition number "
                             "below 10⁴; widen the region, also to complex poles.")) from problem
    assert result is not None
    found = units.given(result.observer, row, here.weighed(design))
    result = replace(result, observer=found)
    if not met(found):
        result = beside(here, design, row, result)
    same_order = chosen.order == result.observer.order and inside(chosen.poles, design)
    if same_order and chosen.condition <= WORST_CONDITION and result.value > chosen.J:
        result = replace(result, observer=chosen, value=chosen.J)
    yield 1.0, result


def beside(here: Here, design: Design, row: np.ndarray, result: RobustObserver) -> RobustObserver:
    """RLO may stop right on a mode of the plant, where J has a kink and precision is lost; then the best observer a hair away."""
    for share in NUDGES:
        for way in (1 + share, 1 - share):
            poles = result.observer.poles * way
            if not inside(poles, design):
                continue
            try:
                near = here.scaled.observer(row, tuple(poles), here.weighed(design), NORMS[design["norm"]])
            except (EngineError, np.linalg.LinAlgError):
                continue
            if met(near) and near.J - result.value < 10 * share * result.value:
                return replace(result, observer=near, value=near.J)
    return result


def shown(setting: Setting, outcome: Outcome[Story], result: RobustObserver) -> Outcome[Story]:
    """The outcome with what RLO found, run under the same errors of the plant."""
    run = run_of(setting, outcome.design, result.observer, setting.errors(outcome.design))
    more = {"J_rlo": float(result.value), "order_rlo": float(result.observer.order),
            "late_error_rlo": run.late(run.e)}
    return replace(outcome, study=replace(outcome.study, found=result, found_run=run), metrics=merge_lazily(outcome.metrics, more))
