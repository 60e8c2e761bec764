"""Errors of many seeds: in the χ² band at its nominal rate for a tuned filter, outside for a mistuned one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom, chi2

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Outcome
from observer_lab.course.many_seeds import (
    CONSISTENT,
    LEVEL,
    OVER_CONFIDENT,
    RADIUS,
    UNDER_CONFIDENT,
    SeedErrors,
    cloud_figure,
    covariance_table,
    verdict_words,
)
from observer_lab.engine import Belief, KalmanFilter
from observer_lab.lessons import LESSONS
from observer_lab.plants.examples import example
from observer_lab.text import Text, same

SEEDED = [name for name, lesson in LESSONS.items() if lesson.seeds is not None]


def outcome_of(name: str, changes: Mapping[str, Any] | None = None) -> Outcome:
    lesson = LESSONS[name]
    return lesson.compute(lesson.apply(lesson.start(), changes or {}))


def errors_of(outcome: Outcome, seeds: np.ndarray) -> SeedErrors:
    trial = LESSONS[outcome.design.lesson].seeds
    assert trial is not None
    found = [each for _, each in trial(outcome, seeds) if each is not None]
    return found[-1]


def seeds(count: int, first: int = 5) -> np.ndarray:
    return np.random.SeedSequence(first).generate_state(count)


def errors_of_a_filter(believed: float, batches: int, count: int) -> list[SeedErrors]:
    """Errors of a Kalman filter after 25 samples in `count` runs, many times; it takes Q for `believed` times what it is."""
    A, C, Q, R = np.array([[0.95, 0.1], [-0.1, 0.9]]), np.eye(2), np.array([[0.3, 0.1], [0.1, 0.2]]), np.diag([1.0, 2.0])
    kf, rng = KalmanFilter(A, np.zeros((2, 1)), C, believed * Q, R), np.random.default_rng(3)
    plan = kf.schedule(Belief(np.zeros(2), np.eye(2)), 25)
    e = rng.standard_normal((batches * count, 2))
    for k in range(25):  # x⁺ = A x + w, x̂⁺ = A x̂ + M (y − C A x̂), so e follows (I − M C)(A e + w) − M v
        M = plan.gains[plan.index[k]]
        pushed = e if k == 0 else e @ A.T + rng.standard_normal(e.shape) @ np.linalg.cholesky(Q).T
        e = pushed @ (np.eye(2) - M @ C).T - rng.standard_normal(e.shape) @ np.sqrt(R) @ M.T
    P = plan.posterior[plan.index[24]]
    path = np.zeros((count, 2))
    return [SeedErrors(1.0, part, P, np.eye(2), (same("a"), same("b")), np.arange(2.0), path, np.ones(2))
            for part in e.reshape(batches, count, 2)]


def test_a_tuned_filter_is_in_the_band_at_the_nominal_rate() -> None:
    batches = 400
    found = errors_of_a_filter(1.0, batches, 40)
    held = sum(verdict_words(each) == CONSISTENT for each in found)
    low, high = binom.ppf([1e-5, 1 - 1e-5], batches, LEVEL)
    assert low <= held <= high, held
    share = np.mean([each.inside.mean() for each in found])
    assert abs(share - LEVEL) < 0.01


@pytest.mark.parametrize("believed, words", [(0.1, OVER_CONFIDENT), (10.0, UNDER_CONFIDENT)])
def test_a_mistuned_filter_is_outside(believed: float, words: Text) -> None:
    found = errors_of_a_filter(believed, 50, 300)
    assert [verdict_words(each) == words for each in found] == [True] * 50


def test_the_average_nees_and_the_band_are_those_of_the_definition() -> None:
    one = errors_of_a_filter(2.0, 1, 60)[0]
    each = [float(e @ np.linalg.solve(one.covariance, e)) for e in one.errors]
    np.testing.assert_allclose(one.judged.values, [np.mean(each)], rtol=1e-12)
    np.testing.assert_allclose(one.judged.band, chi2.ppf([0.025, 0.975], 60 * 2) / 60, rtol=1e-9)
    np.testing.assert_array_equal(one.inside, np.array(each) <= chi2.ppf(LEVEL, 2))
    assert abs(RADIUS**2 - chi2.ppf(LEVEL, 2)) < 1e-12


@pytest.mark.parametrize("name, changes, words", [
    ("noise", {}, CONSISTENT), ("kalman", {"q": 1.0, "r": 1.0, "p0": 1.0}, CONSISTENT), ("kalman", {}, OVER_CONFIDENT),
    ("kalman", {"q": 1.0, "r": 30.0}, UNDER_CONFIDENT), ("showdown", {"play": "lqe"}, CONSISTENT), ("showdown", {"adc": 5.0}, None),
    ("nonlinear", {"case": "platform"}, CONSISTENT), ("nonlinear", {"case": "fall"}, OVER_CONFIDENT)])
def test_each_lesson_says_what_its_design_is(name: str, changes: Mapping[str, Any], words: Text | None) -> None:
    found = errors_of(outcome_of(name, changes), seeds(200))
    assert words is None or verdict_words(found) == words, found.judged
    assert len(cloud_figure(found).points) == found.count and len(covariance_table(found).rows) == 3


@pytest.mark.parametrize("name, changes", [(name, {}) for name in SEEDED] + [
    ("nonlinear", {"case": "platform"}), ("nonlinear", {"case": "pendulum"}), ("kalman", {"noise": "carried"})])
def test_a_seed_gives_the_same_run_whichever_others_run_beside_it(name: str, changes: Mapping[str, Any]) -> None:
    outcome = outcome_of(name, changes)
    drawn = seeds(7)
    whole, some = errors_of(outcome, drawn), errors_of(outcome, drawn[[4, 1]])
    np.testing.assert_allclose(some.errors, whole.errors[[4, 1]], rtol=1e-9, atol=1e-15, equal_nan=True)
    np.testing.assert_allclose(some.paths, whole.paths[[4, 1]], rtol=1e-9, atol=1e-12, equal_nan=True)
    assert whole.paths.shape == (7, len(whole.times)) and np.broadcast_to(whole.sigmas, whole.paths.shape).shape == whole.paths.shape
    np.testing.assert_allclose(whole.paths[:, -1][whole.kept], (whole.errors @ whole.rows.T)[whole.kept, 0], rtol=1e-9, atol=1e-15)


def test_an_unstable_loop_says_so() -> None:
    outcome = outcome_of("showdown", {"play": "siso", "delay": 10.0})
    with pytest.raises(KnobError, match="unstable"):
        errors_of(outcome, seeds(2))


def test_four_lessons_run_seeds_and_no_own_plant_does() -> None:
    assert sorted(SEEDED) == ["kalman", "noise", "nonlinear", "showdown"]
    for name in ("noise", "kalman"):
        assert LESSONS[name].fit(example("aircraft")).seeds is None, name
