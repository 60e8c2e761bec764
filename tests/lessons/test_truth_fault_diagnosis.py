"""The mean time between false alarms that is shown is that of the bank that runs: against long simulations of our own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chi2

from observer_lab.lessons.fault_diagnosis.diagnosis import ENERGY, MEAN, Rule
from observer_lab.lessons.fault_diagnosis.job import false_alarms
from observer_lab.lessons.fault_diagnosis.lesson import LESSON
from observer_lab.lessons.fault_diagnosis.observer_bank import DT, guard, model
from observer_lab.lessons.fault_diagnosis.run_length import bank_run, cusum, member_run, rate_for, seconds_between
from observer_lab.lessons.fault_diagnosis.runs import Case, draw, simulate

SAMPLED = (Rule(), Rule(MEAN, 60, 1e-3), Rule(ENERGY, 1, 1e-3), Rule(MEAN, 10, 0.05), Rule(ENERGY, 150, 3e-3), Rule(ENERGY, 4, 1e-4))


def healthy(chains: int, count: int, seed: int) -> np.ndarray:
    """Whitened innovations (count, chains, 7, 3) of the bank on a deck without a force, after settling."""
    kf, g = model(), guard()
    rng, settling = np.random.default_rng(seed), 300
    w = rng.multivariate_normal(np.zeros(6), kf.Q, (count + settling, chains), method="eigh")
    v = rng.multivariate_normal(np.zeros(4), kf.R, (count + settling, chains))
    slots = np.empty((count, chains, 7, 3))
    system = g.bank.system
    Bank, By, H, Dy = system.A, system.B[:, 3:], system.C, np.asarray(system.D)[:, 3:]
    x, state = np.zeros((chains, 6)), np.zeros((chains, len(Bank)))
    for k in range(count + settling):
        y = x @ kf.C.T + v[k]
        if k >= settling:
            slots[k - settling] = (state @ H.T + y @ Dy.T).reshape(chains, 7, 3)
        state, x = state @ Bank.T + y @ By.T, x @ kf.A.T + w[k]
    return slots


def statistic(rule: Rule, rho: np.ndarray) -> np.ndarray:
    """Windows that end at each sample by a moving sum of scipy, zero before the first is full: (count, chains, 7)."""
    N = rule.window
    if rule.statistic == ENERGY:
        out = lfilter(np.ones(N), [1.0], (rho**2).sum(axis=3), axis=0)
    else:
        out = (lfilter(np.ones(N), [1.0], rho, axis=0)**2).sum(axis=3) / N
    out[:N - 1] = 0.0
    return out


def mean_run(over: np.ndarray, window: int) -> tuple[float, int]:
    """Samples from an empty window to an alarm, by going through each series (count, series); and how many alarms there were."""
    full, alarms = 0, 0
    for series in over.reshape(len(over), -1).T:
        begin = 0
        for at in np.flatnonzero(series):
            if at - begin >= window - 1:
                full, alarms, begin = full + int(at) - begin - window + 2, alarms + 1, int(at) + 1
        full += max(len(series) - begin - window + 1, 0)
    return window - 1 + full / max(alarms, 1), alarms


@pytest.mark.slow
def test_the_shown_times_are_those_of_a_long_simulation() -> None:
    rho = healthy(60, 12_000, 5)
    for rule in SAMPLED:
        over = statistic(rule, rho) > chi2.isf(rule.rate, 3 * (rule.window if rule.statistic == ENERGY else 1))
        for shown, seen, spread in ((bank_run(rule), over.any(axis=2), 1.0), (member_run(rule), over, 1.7)):
            true, alarms = mean_run(seen, rule.window)
            assert alarms > 100 and shown == pytest.approx(true, rel=0.05 + 3 * spread / np.sqrt(alarms)), (rule, shown, true, alarms)


def test_a_window_of_one_sample_gives_what_the_quantile_says() -> None:
    for rate in (0.1, 1e-2, 1e-3, 1e-4):
        for kind in (ENERGY, MEAN):
            assert member_run(Rule(kind, 1, rate)) == pytest.approx(1 / rate, rel=0.03)
            assert 1 / (7 * rate) * 0.97 < bank_run(Rule(kind, 1, rate)) < 1 / rate


def test_windows_at_every_sample_give_more_alarms_than_windows_side_by_side() -> None:
    for rule in SAMPLED:
        if rule.window > 1:
            assert bank_run(rule) < member_run(rule) < (rule.window / rule.rate if rule.rate < 0.01 else np.inf)


def test_the_time_grows_as_alarms_become_rarer() -> None:
    for kind in (ENERGY, MEAN):
        for window in (1, 2, 7, 25, 100, 150):
            runs = [f(Rule(kind, window, rate)) for f in (bank_run, member_run) for rate in np.geomspace(0.1, 1e-6, 41)]
            assert np.all(np.diff(runs[:41]) > 0) and np.all(np.diff(runs[41:]) > 0)
            rate = rate_for(kind, window, 3600.0)
            assert rate is not None and seconds_between(Rule(kind, window, rate)) == pytest.approx(3600, rel=1e-9)


def test_the_sum_has_the_run_length_of_the_window() -> None:
    rng, record = np.random.default_rng(2), simulate(Case(), draw(1))
    for rule in (Rule(rate=1e-2), Rule(MEAN, 10, 0.02)):
        found = cusum(rule, record)
        g, length, runs = np.zeros(3000), np.zeros(3000), np.ones(3000, dtype=bool)
        while runs.any():
            length += runs
            g = np.maximum(0.0, g + rng.chisquare(3, 3000) - 3 - found.slack)
            runs &= g <= found.threshold
        assert length.mean() == pytest.approx(member_run(rule), rel=0.08)


def test_the_job_counts_alarms_as_the_table_does() -> None:
    over = np.random.default_rng(3).random((500, 4)) < 0.02
    count, full = false_alarms(over, 10)
    true, alarms = mean_run(over, 10)
    assert count == alarms and 9 + full / count == pytest.approx(true)


def test_the_page_says_the_mean_time_of_the_bank() -> None:
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"window": 40, "rate": 1e-4}))
    table = next(f for f in LESSON.figures(outcome) if f.id == "counts")
    seconds = DT * bank_run(Rule(ENERGY, 40, 1e-4))
    assert outcome.metrics["between"] == pytest.approx(seconds) and f"{seconds / 60:.3g} min" in table.caption("en")
