"""What is said of the bound: an honest ±, the lower limit where a better filter is spoken of, and none where the plant is linear."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from observer_lab.lessons.nonlinear.cramer_rao import Bound, words
from observer_lab.lessons.nonlinear.lesson import LESSON

LINEAR: dict[str, Any] = {"case": "platform", "hardening": 0.0, "weakening": 0.0}


def said(**moves: Any) -> str:
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), moves))
    return next(f for f in LESSON.figures(outcome) if f.id == "errors").caption("en")


@pytest.mark.slow
def test_the_true_multiple_lies_beyond_two_standard_errors_in_one_run_of_twenty() -> None:
    """On the linear platform the EKF is the Kalman filter: its error is the bound, once."""
    z = []
    for seed in range(150):
        bound = LESSON.compute(LESSON.apply(LESSON.start(), {**LINEAR, "seed": seed})).study.bound
        z.append((bound.times["ekf"] - 1) / bound.unsure["ekf"])
    assert 0.01 <= np.mean(np.abs(z) > 2) <= 0.095 and 0.8 < np.std(z) < 1.25


@pytest.mark.parametrize("who", ["kf", "ekf", "ukf"])
def test_on_a_linear_plant_no_filter_is_better(who: str) -> None:
    for seed in (1, 2):
        assert "the " + who.upper() + " is the Kalman filter" in said(**LINEAR, filter=who, seed=seed)
    assert "is the Kalman filter" not in said(**{**LINEAR, "hardening": 0.3}, filter=who)
    assert ("is the Kalman filter" in said(**LINEAR, filter=who, redraw=False)) == (who != "ukf")


@pytest.mark.parametrize(("times", "unsure", "expected"), [(1.0, 0.05, "no filter could have an error"),
                                                           (1.5, 0.3, "It takes more than 8 runs"), (3.0, 0.2, "at least 62 % below"),
                                                           (1.45, 0.1, "at least 20 % below")])
def test_a_better_filter_is_spoken_of_by_the_lower_limit(times: float, unsure: float, expected: str) -> None:
    bound = Bound(np.ones(2), {"ekf": times}, {"ekf": unsure})
    assert expected in words("ekf", bound, 8, 0, False, False)("en")
