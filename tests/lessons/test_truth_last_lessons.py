"""Lessons 15 to 21: what never happens is infinite, and an unstable loop is said first; each beside a witness of its own."""

from __future__ import annotations

import math

import numpy as np
import pytest

from observer_lab.course.lesson import Outcome
from observer_lab.lessons import LESSONS


def outcome(id: str, **values: object) -> Outcome:
    lesson = LESSONS[id]
    return lesson.compute(lesson.apply(lesson.start(), values))


@pytest.mark.parametrize("values", [{}, {"load": -2.0}, {"load": 0.0}, {"load_state": False}, {"gap": 3.0},
                                    {"observer_poles": (-0.4, -0.5, -0.6)}])
def test_a_load_that_is_not_found_is_found_never(values: dict[str, object]) -> None:
    o = outcome("arm", **values)
    assert o.run is not None
    away = np.abs(o.run.x[:, 3] - o.run.xhat[:, 3])[o.run.t >= 1.0 - 1e-9]
    load = abs(float(o.design["load"]))
    assert math.isfinite(o.metrics["found_after"]) == (load > 0 and bool(away[-1] <= 0.05 * load))


@pytest.mark.parametrize("values", [{}, {"bias": 0.5}, {"place": "none"}, {"stiffer": 20.0}, {"place": "VL", "kind": "stuck"}])
def test_a_fault_that_is_not_identified_has_no_delay(values: dict[str, object]) -> None:
    o = outcome("fault-diagnosis", **values)
    right = "correctly identified" in o.live("en")
    assert math.isfinite(o.metrics["delay"]) == right and not o.metrics["delay"] < 0


@pytest.mark.parametrize("a", [1.05, 1.2, 1.5, 2.0])
@pytest.mark.parametrize("delay", [0, 1, 2, 4])
def test_an_unstable_delayed_loop_is_said_first(a: float, delay: int) -> None:
    """The ball alone, steered by the state of `delay` samples ago: it grows, or it does not."""
    o = outcome("network", a=a, delay=delay)
    plant, K = o.study.watched.sampled.plant, o.gains["K"]
    x = [np.ones(plant.n)] * (delay + 1)
    for _ in range(400):
        x.append(plant.A @ x[-1] - plant.B @ K @ x[-1 - delay])
    grows = float(np.abs(x[-delay - 20:]).max()) > 1.0
    assert o.live("en").startswith("With this delay the loop is unstable") == grows


@pytest.mark.parametrize("poles", [(2 - 6j, 2 + 6j), (-3 + 0j, 1 + 0j)])
def test_an_unstable_arm_is_said_first(poles: tuple[complex, complex]) -> None:
    assert outcome("arm", controller_poles=poles).live("en").startswith("A controller pole is not in the left half plane")
    assert outcome("arm").live("en").startswith("The load is found")


@pytest.mark.parametrize("values", [{}, {"order": 1}, {"data": "furnace"}, {"data": "masses"}, {"factor": 100.0}, {"factor": 0.01}])
def test_consistent_needs_white_innovations(values: dict[str, object]) -> None:
    o = outcome("record", **values)
    said = "the filter is consistent" in o.live("en")
    m = o.metrics
    assert said == all(check.holds for check in o.checks if check.id != "poles")
    assert not said or (m["nis_low"] <= m["mean_nis"] <= m["nis_high"] and m["white_p"] >= 0.01)
