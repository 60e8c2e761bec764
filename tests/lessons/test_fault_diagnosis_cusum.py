"""The cumulative sum beside the window: its threshold against drawn noise, its recursion, and what the step says of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from observer_lab.lessons.fault_diagnosis.diagnosis import MEAN, Rule
from observer_lab.lessons.fault_diagnosis.lesson import LESSON
from observer_lab.lessons.fault_diagnosis.observer_bank import FAULT_PLACES, guard
from observer_lab.lessons.fault_diagnosis.run_length import cusum, member_run, run_length, threshold
from observer_lab.lessons.fault_diagnosis.runs import Case, draw, simulate

RECORDS = 14


@pytest.mark.parametrize(("dof", "slack", "h"), [(3, 1.0, 8.0), (3, 0.4, 12.0), (2, 0.7, 6.0)])
def test_the_mean_run_of_the_chain_is_that_of_drawn_noise(dof: int, slack: float, h: float) -> None:
    rng, count = np.random.default_rng(1), 4000
    g, length = np.zeros(count), np.zeros(count)
    running = np.ones(count, dtype=bool)
    while running.any():
        length += running
        g = np.maximum(0.0, g + rng.chisquare(dof, count) - dof - slack)
        running &= g <= h
    assert run_length(dof, slack, h) == pytest.approx(length.mean(), abs=4 * length.std() / np.sqrt(count))


@pytest.mark.parametrize("mean", [20.0, 25_000.0, 1.5e8])
def test_the_threshold_gives_the_run_that_is_asked_for(mean: float) -> None:
    slack = (chi2.isf(1 / mean, 3) - 3) / 4
    assert run_length(3, slack, threshold(3, slack, mean)) == pytest.approx(mean, rel=1e-6)
    alone = threshold(3, (chi2.isf(1 / mean, 3) - 3) / 1.0 - 1e-9, mean)  # with all the slack there can be, one sample does it
    assert alone < 0.5


@pytest.mark.parametrize("rule", [Rule(), Rule(MEAN, 60, 1e-5), Rule(window=1, rate=0.1), Rule(window=150, rate=1e-6)])
def test_the_sum_is_its_recursion(rule: Rule) -> None:
    record = simulate(Case("HL", size=2.0), draw(3))
    found, g = cusum(rule, record), np.zeros(7)
    for k, r in enumerate(record.residuals):
        g = np.maximum(0.0, g + (np.asarray(r) ** 2).sum(axis=1) - guard().bank.dof - found.slack)
        np.testing.assert_allclose(found.values[k] * found.threshold, g, atol=1e-8)
    assert found.mean == member_run(rule) and found.slack > 0 and found.threshold > 0


def test_large_faults_are_seen_sooner_by_the_sum_and_small_ones_by_the_window() -> None:
    """As the step says of 3 and of 1 mm/s, over records and over the three members that hear HL."""
    def sooner(size: float) -> tuple[int, int]:
        case, rule, counts = Case("HL", size=size), Rule(), np.zeros(2, dtype=int)
        for seed in range(RECORDS):
            record = simulate(case, draw(2000 + seed))
            for member in (i for i in range(4) if i != FAULT_PLACES.index("HL")):
                first = [int(np.argmax(np.append(values[case.start:, member] > 1, True)))
                         for values in (cusum(rule, record).values, rule.values(record.residuals) / rule.threshold)]
                counts += (first[0] < first[1], first[0] > first[1])
        return int(counts[0]), int(counts[1])
    large, small = sooner(3.0), sooner(1.0)
    assert large[0] > 1.3 * large[1] and small[1] > 2 * small[0]


def test_the_caption_says_when_both_cross() -> None:
    figure: Any = next(f for f in LESSON.figures(LESSON.compute(LESSON.start())) if f.id == "cusum")
    for curve, name in zip(figure.curves[:2], ("window", "total"), strict=True):
        at = f"{figure.x[np.argmax(curve.y > 1)]:.2f} s"
        assert dict(figure.caption.values)[name]("en") == at and at in figure.caption("en")
    healthy: Any = next(f for f in LESSON.figures(LESSON.compute(LESSON.apply(LESSON.start(), {"place": "none"}))) if f.id == "cusum")
    assert "no time" in healthy.caption("en") and "从未" in healthy.caption("zh")
