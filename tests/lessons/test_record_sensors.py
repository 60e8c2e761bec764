"""Lesson 21: a faulty sensor behind a gate, and a second sensor with another clock."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.lessons import LESSONS
from observer_lab.lessons.record.data import record_of
from observer_lab.lessons.record.estimates import estimates
from observer_lab.lessons.record.fusion import BEFORE, DELAY, EVERY, SHOWN, fused

LESSON = LESSONS["record"]


def outcome(**changes: object):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def test_a_gate_sets_the_jumps_aside_and_lets_the_bias_pass() -> None:
    given = record_of("faulty", 1)
    plain, gated, sound = outcome(data="faulty"), outcome(data="faulty", gate="0.999"), outcome()
    aside = gated.study.judged.set_aside
    jumped = np.abs(given.jumps[:, 0]) > 0
    assert jumped.sum() >= 5 and aside[jumped].all() and not aside[~jumped].any()
    assert plain.metrics["mean_nis"] > plain.metrics["nis_high"] and gated.metrics["mean_nis"] < gated.metrics["nis_high"]
    assert f"The gate set {aside.sum()} of 800 rows aside" in gated.live("en")
    away = (gated.study.estimate(False) - gated.study.clean)[:, 0]
    right = (sound.study.estimate(False) - sound.study.clean)[:, 0]
    biased = given.bias[gated.study.first:, 0] > 0
    assert np.abs(away - right)[~biased].max() < 0.07 and np.mean((away - right)[biased]) > 0.5 * given.bias.max()
    assert gated.metrics["white_p"] < 1e-3 < plain.metrics["white_p"]


def test_exports_mark_the_rows_that_a_gate_set_aside_as_missing() -> None:
    gated = outcome(data="faulty", gate="0.999")
    aside = gated.study.judged.set_aside
    names, rows = estimates(gated)
    table = np.array(rows)
    np.testing.assert_array_equal(np.isnan(table[:, names.index("y")]), aside)
    assert np.isfinite(np.delete(table, names.index("y"), axis=1)).all()
    assert LESSON.code is not None and LESSON.device is not None
    written = {value.name: value.value for value in LESSON.code(gated).given}
    np.testing.assert_array_equal(np.isnan(np.asarray(written["y"]))[:, 0], aside)


@pytest.mark.parametrize("second", ["slow", "late"])
def test_the_spread_with_two_sensors_is_that_of_all_readings_at_once(second: str) -> None:
    """Beside the conditional variance of one Gaussian vector of all outputs and readings, without a filter."""
    study = outcome(second=second).study
    kf, P = study.found.fitted.kalman(), study.judged.track.schedule.prior[-1]
    found, count = fused(kf, P, second), BEFORE + SHOWN
    n = kf.n
    G = np.zeros((count, n, (count + 1) * n))  # x_k = G_k (x_0, w_0, w_1, …)
    G[0, :, :n] = np.eye(n)
    for k in range(1, count):
        G[k] = kf.A @ G[k - 1]
        G[k, :, k * n:(k + 1) * n] += np.eye(n)
    source = np.zeros(((count + 1) * n, (count + 1) * n))
    source[:n, :n] = P
    for k in range(1, count + 1):
        source[k * n:(k + 1) * n, k * n:(k + 1) * n] = kf.Q
    z = np.einsum("i,kij->kj", kf.C[0], G)
    cov, late = z @ source @ z.T, DELAY if second == "late" else 0
    for k in (BEFORE, BEFORE + EVERY, BEFORE + EVERY + 3, BEFORE + EVERY + DELAY, count - 1):
        rows = np.arange(k + 1)
        arrives = [j for j in rows - BEFORE if (j + late) > 0 and j % EVERY == 0 and j + late <= k - BEFORE]
        at = np.concatenate([rows, np.array(arrives, dtype=int) + BEFORE])
        noise = np.diag([kf.R[0, 0]] * len(rows) + [found.exact**2] * len(arrives))
        left = cov[k, k] - cov[k, at] @ np.linalg.solve(cov[np.ix_(at, at)] + noise, cov[at, k])
        assert found.both[k - BEFORE] == pytest.approx(np.sqrt(left), rel=1e-4)


def test_an_exact_reading_gains_much_at_once_and_little_when_it_is_late() -> None:
    now, late = outcome(second="slow").metrics, outcome(second="late").metrics
    assert now["sigma_least"] < 0.25 * now["sigma"] and now["sigma_most"] > 0.95 * now["sigma"]
    assert late["sigma_least"] > 0.9 * late["sigma"]
