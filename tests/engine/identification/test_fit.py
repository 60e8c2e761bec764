"""The fit of plant, noises and smoother beside what is known: exact plants, SciPy's equations, batch least squares, many seeds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from record_laws import PLANTS, judged
from records_of_faults import FAULTS, SLOW, clean, drift, fault_trials, late, missing, spikes
from scipy.linalg import block_diag, solve_discrete_are, toeplitz

from observer_lab.engine import Belief, EngineError, KalmanFilter, Plant
from observer_lab.engine.identification import Record, filter_record, fit_noise, identify, resample, subspace
from observer_lab.engine.identification.noise_fit import steady_gain
from observer_lab.engine.identification.smoother import smooth
from observer_lab.engine.identification.subspace import noise_edge


def answer(A: np.ndarray, B: np.ndarray, C: np.ndarray, u: np.ndarray) -> np.ndarray:
    x, out = np.zeros(len(A)), []
    for row in u:
        out.append(C @ x)
        x = A @ x + B @ row
    return np.array(out)


@pytest.mark.parametrize("plant", PLANTS[:3], ids=lambda plant: plant.name)
def test_without_noise_the_poles_are_exact(plant) -> None:
    A, B, C = plant.sampled()
    u = np.random.default_rng(2).standard_normal((900, 1))
    found = subspace(u, answer(A, B, C, u), order=len(A))
    np.testing.assert_allclose(np.sort_complex(found.poles), np.sort_complex(np.linalg.eigvals(A)), atol=1e-9)
    assert found.suggested == len(A)


def test_the_fitted_plant_answers_as_the_true_one() -> None:
    A, B, C = PLANTS[0].sampled()
    found = identify(PLANTS[0].record(3), order=2).fitted.plant
    def impulse(A, B, C):
        return np.array([C @ np.linalg.matrix_power(A, k) @ B for k in range(40)]).ravel()
    true = impulse(A, B, C)
    assert np.abs(impulse(found.A, found.B, found.C) - true).max() < 0.1 * np.abs(true).max()


@pytest.mark.slow
@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant.name)
def test_poles_and_nis_lie_within_what_is_said(plant) -> None:
    """The first five seeds of the hundred of `record_laws.py`, at most one of which may fail: of the spring one record's poles lie 3.6
    deviations away."""
    found = [judged(plant, seed)[:2] for seed in range(5)]
    assert sum(each == (True, True) for each in found) >= 4, found


@pytest.mark.slow
def test_the_stated_deviation_is_the_spread_over_seeds() -> None:
    plant = PLANTS[0]
    true = np.sort_complex(np.linalg.eigvals(plant.sampled()[0]))
    found = [subspace(record.u, record.y, order=2) for record in map(plant.record, range(24))]
    spread = np.sqrt(np.mean([np.abs(f.poles - true) ** 2 for f in found], axis=0))
    stated = np.mean([f.deviations for f in found], axis=0)
    np.testing.assert_allclose(stated, spread, rtol=0.4)


def test_noise_alone_stays_below_its_edge() -> None:
    rng = np.random.default_rng(0)
    a, b, count = 10, 20, 600
    top = []
    for _ in range(20):
        X, Y = (np.linalg.qr(rng.standard_normal((count, k)))[0] for k in (a, b))
        top.append(np.linalg.svd(X.T @ Y, compute_uv=False)[0])
    edge = noise_edge(a, b, count)
    assert max(top) < edge < 1.3 * np.mean(top)


def test_the_steady_gain_is_that_of_scipy() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        A, C, G = rng.standard_normal((4, 4)), rng.standard_normal((2, 4)), rng.standard_normal((4, 2))
        A *= rng.uniform(0.3, 1.2) / np.abs(np.linalg.eigvals(A)).max()
        Q, R = G @ G.T, np.diag(rng.uniform(0.1, 2.0, 2))
        P = solve_discrete_are(A.T, C.T, Q, R)
        S = C @ P @ C.T + R
        K, found = steady_gain(A, C, Q, R)
        np.testing.assert_allclose(K, A @ P @ C.T @ np.linalg.inv(S), atol=1e-9 * np.abs(K).max())
        np.testing.assert_allclose(found, S, rtol=1e-9)


@pytest.mark.slow
def test_the_likely_noises_of_a_known_plant_are_near_the_true_ones() -> None:
    known = PLANTS[0]
    A, B, C = known.sampled()
    plant = Plant(A, B, C, None, known.dt)
    found = [fit_noise(plant, known.record(seed)) for seed in range(6)]
    K, S = steady_gain(A, C, known.q**2 * B @ B.T, known.r**2 * np.eye(1))
    gains = [steady_gain(A, C, f.Q, f.R)[0] for f in found]
    np.testing.assert_allclose(np.mean(gains, axis=0), K, atol=0.3 * np.abs(K).max())
    assert np.mean([f.R[0, 0] for f in found]) == pytest.approx(known.r**2, rel=0.1)
    assert np.mean([steady_gain(A, C, f.Q, f.R)[1][0, 0] for f in found]) == pytest.approx(S[0, 0], rel=0.1)


@pytest.mark.parametrize("every", [0, 3, 7])
def test_no_noises_near_the_found_ones_are_more_likely(every: int) -> None:
    """−2 log L of the measured rows by their whole covariance matrix, without any filter; one row of some is missing."""
    a, count = 0.8, 300
    rng = np.random.default_rng(4)
    x = np.zeros(count)
    for k in range(1, count):
        x[k] = a * x[k - 1] + 0.3 * rng.standard_normal()
    y = x + 0.5 * rng.standard_normal(count)
    seen = np.arange(count) % every != 0 if every else np.ones(count, dtype=bool)
    read = np.where(seen, y, np.nan)
    found = fit_noise(Plant([[a]], [[1.0]], [[1.0]], None, 1.0), Record(np.arange(count), np.zeros((count, 1)), read))
    shrink = (seen.sum() - 1) / (seen.sum() + 1)  # what the fit adds for rows to come

    def level(q: float, r: float) -> float:
        S = (q / (1 - a**2) * toeplitz(a ** np.arange(count)) + r * np.eye(count))[np.ix_(seen, seen)]
        return float(np.linalg.slogdet(S)[1] + y[seen] @ np.linalg.solve(S, y[seen]))
    q, r = shrink * found.Q[0, 0], shrink * found.R[0, 0]
    best = level(q, r)
    assert all(level(q * g, r * h) > best - 0.3 for g in (0.5, 1.0, 2.0) for h in (0.7, 1.0, 1.4))
    assert level(4 * q, r) > best + 1 and level(q, 2 * r) > best + 1


@pytest.mark.parametrize("steps", [30, 400])
def test_the_smoother_is_the_least_squares_over_the_whole_record(steps: int) -> None:
    rng = np.random.default_rng(steps)
    A, C = np.array([[0.9, 0.2], [-0.1, 0.8]]), np.array([[1.0, 0.0]])
    Q, R, P0 = np.diag([0.1, 0.3]), np.eye(1) * 0.5, np.eye(2)
    y = rng.standard_normal((steps, 1))
    kf = KalmanFilter(A, np.zeros((2, 1)), C, Q, R)
    found = smooth(kf, kf.run(Belief([0, 0], P0), y))
    T = np.eye(2 * steps) - np.kron(np.eye(steps, k=-1), A)  # T x = (x₀, w₀, w₁, …)
    W = block_diag(np.linalg.inv(P0), *[np.linalg.inv(Q)] * (steps - 1))
    H = np.kron(np.eye(steps), C)
    information = T.T @ W @ T + H.T @ H / R[0, 0]
    np.testing.assert_allclose(found.means.ravel(), np.linalg.solve(information, H.T @ y / R[0, 0]).ravel(), atol=1e-8)
    np.testing.assert_allclose(found.variances.ravel(), np.diag(np.linalg.inv(information)), atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("which", ["one of seventeen", "one of ten by chance"])
def test_scattered_gaps_leave_poles_and_noises_where_they_were(which: str) -> None:
    """Short stretches between the gaps have no start of their own: that would explain what the process noise does."""
    for seed in range(3):
        record, rng = PLANTS[0].record(seed), np.random.default_rng(seed)
        lost = np.arange(record.rows) % 17 == 5 if which == "one of seventeen" else rng.random(record.rows) < 0.1
        y = np.where(lost[:, None], np.nan, record.y)
        whole, found = (identify(Record(record.t, record.u, each), order=2, delay=0, degree=0) for each in (record.y, y))
        assert np.abs(np.sort_complex(found.subspace.poles) - np.sort_complex(whole.subspace.poles)).max() < 0.02
        sizes = [steady_gain(f.fitted.plant.A, f.fitted.plant.C, f.fitted.Q, f.fitted.R)[1][0, 0] for f in (whole, found)]
        assert sizes[1] == pytest.approx(sizes[0], rel=0.15) and found.fitted.R[0, 0] == pytest.approx(whole.fitted.R[0, 0], rel=0.25)
        assert found.judged.mean_nis == pytest.approx(whole.judged.mean_nis, rel=0.25)


def test_gaps_are_no_reason_to_stop() -> None:
    record = PLANTS[0].record(1)
    y = np.array(record.y)
    y[300:330], y[700:705] = np.nan, np.nan
    found = identify(Record(record.t, record.u, y), order=2)
    assert found.judged.nis_holds and found.judged.whiteness is None and 0 < found.judged.evidence.white <= 1
    true = np.sort_complex(np.linalg.eigvals(PLANTS[0].sampled()[0]))
    assert (np.abs(found.subspace.poles - true) < 4 * found.subspace.deviations).all()


def test_units_change_nothing_but_units() -> None:
    record = PLANTS[0].record(0)
    plain, other = (identify(r, order=2) for r in (record, Record(record.t, 1e-6 * record.u, 1e9 * record.y + 3e9)))
    np.testing.assert_allclose(other.subspace.poles, plain.subspace.poles, rtol=1e-6)
    assert other.judged.mean_nis == pytest.approx(plain.judged.mean_nis, rel=1e-3)
    assert other.fitted.R[0, 0] == pytest.approx(1e18 * plain.fitted.R[0, 0], rel=0.02)


def test_without_inputs_the_noise_alone_is_modelled() -> None:
    rng = np.random.default_rng(0)
    y = np.zeros(1500)
    for k in range(1, 1500):
        y[k] = 0.9 * y[k - 1] + rng.standard_normal()
    found = identify(Record(np.arange(1500), np.zeros((1500, 0)), y + 0.5 * rng.standard_normal(1500)), order=1)
    assert found.subspace.poles[0].real == pytest.approx(0.9, abs=0.05) and found.judged.consistent


def test_a_filter_with_a_wrong_q_leaves_its_band() -> None:
    found = identify(replace(PLANTS[0], q=1.0, r=0.02).record(0), order=2)
    assert found.judged.nis_holds
    for factor, above in ((0.01, True), (100.0, False)):
        wrong = filter_record(found.fitted, found.record, found.judged.first, factor=factor)
        assert (wrong.mean_nis > wrong.band[1]) if above else (wrong.mean_nis < wrong.band[0])


@pytest.mark.parametrize("act, words", [
    (lambda: subspace(np.ones((400, 1)), np.random.default_rng(0).standard_normal((400, 1))), "do not excite"),
    (lambda: subspace(np.zeros((30, 1)), np.ones((30, 1))), "complete windows"),
    (lambda: subspace(np.zeros((400, 0)), np.random.default_rng(0).standard_normal((400, 1)), order=9, horizon=4), "order must be"),
    (lambda: fit_noise(Plant([[0.5]], [[1, 1]], [[1]], None, 1.0), Record(np.arange(50), np.zeros(50), np.ones(50))), "2 inputs"),
    (lambda: fit_noise(Plant([[0.5]], [[1]], [[1]], None, 2.0), Record(np.arange(50), np.zeros(50), np.ones(50))), "every 2 s"),
])
def test_what_cannot_be_fitted_is_refused(act, words: str) -> None:
    with pytest.raises(EngineError, match=words):
        act()


# --- evidence and faults --------------------------------------------------------------------------------------------------
def test_a_clean_record_passes_every_check_and_a_wrong_order_fails() -> None:
    record = PLANTS[2].record(1)
    assert identify(record, order=4).judged.consistent
    wrong = identify(record, order=2).judged
    assert not wrong.consistent and any("order or dead time" in said for said in wrong.evidence.failures)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, _ in FAULTS])
def test_a_record_with_a_fault_gives_its_poles_or_no_consistent_filter(name: str) -> None:
    """Three seeds of the many of tests/engine/records_of_faults.py."""
    plant = PLANTS[0]
    limit = 2 * max(t.error for t in clean(plant, 3)) * (SLOW if name == "two rates" else 1) + 0.02
    trials = fault_trials(name, plant, 3)
    assert name != "feedback" or any(t.contradicted for t in trials), "the witness sees it by itself"
    for found in trials:
        assert not (found.consistent and found.contradicted)
        assert found.error <= limit if name != "feedback" else not found.consistent


@pytest.mark.slow
def test_the_share_of_right_orders_that_are_rejected_is_small() -> None:
    trials = [t for plant in PLANTS[:2] for t in clean(plant, 10)]
    assert sum(not t.consistent for t in trials) <= 4  # five in a hundred are expected


def test_outliers_are_named_and_set_aside() -> None:
    plant = PLANTS[0]
    record = spikes(plant.record(0), plant, np.random.default_rng(1))
    found = identify(record, order=2)
    added = np.abs(record.y - plant.record(0).y) > 0
    assert (found.outliers & added).sum() >= 0.85 * added.sum() and (found.outliers & ~added).sum() <= 2
    assert any("Outliers that were set aside" in note for note in found.record.notes)
    kept = identify(record, order=2, robust=False)
    assert kept.fitted.R[0, 0] > 2 * found.fitted.R[0, 0] and not kept.outliers.any()


def test_missing_rows_stay_missing() -> None:
    record = missing(PLANTS[0].record(0), PLANTS[0], np.random.default_rng(2))
    regular = resample(record)
    assert np.isnan(regular.y).sum() == PLANTS[0].rows - record.rows and "stay missing" in regular.notes[0]
    found = identify(record, order=2)
    assert np.isnan(found.record.y).sum() == np.isnan(regular.y).sum()
    assert found.fitted.R[0, 0] == pytest.approx(PLANTS[0].r ** 2, rel=0.2)


def test_a_dead_time_and_a_drift_are_named() -> None:
    plant = PLANTS[0]
    found = identify(late(plant.record(0), plant, np.random.default_rng(0)), order=2)
    assert 8 <= found.delay <= 12 and any("dead time" in note for note in found.record.notes)
    assert any("drift" in note for note in identify(drift(plant.record(0), plant, np.random.default_rng(0)), order=2).record.notes)


def test_the_suggestion_is_accepted() -> None:
    rng = np.random.default_rng(0)
    record = Record(np.arange(70), np.zeros((70, 0)), np.cumsum(rng.standard_normal(70)))
    found = identify(record)
    assert len(found.subspace.A) == found.subspace.suggested
    assert identify(PLANTS[2].record(0)).subspace.by_information == 4


def test_a_gate_sets_spikes_aside_in_rows_that_were_not_fitted() -> None:
    plant = PLANTS[0]
    clean_record = plant.record(4)
    half = clean_record.rows // 2
    y = np.array(spikes(clean_record, plant, np.random.default_rng(1)).y)
    y[:half] = clean_record.y[:half]
    spiked = np.abs(y - clean_record.y)[:, 0] > 0
    found = identify(Record(clean_record.t, clean_record.u, y), order=2, robust=False)
    plain = found.judged
    gated = filter_record(found.fitted, found.record, plain.first, gate=0.999)
    assert not plain.consistent and not plain.nis_holds and not plain.set_aside.any()
    assert gated.nis_holds and gated.consistent
    assert gated.set_aside[spiked].mean() > 0.95 and gated.set_aside[half:][~spiked[half:]].mean() < 0.01
    np.testing.assert_array_equal(np.isnan(gated.track.innovations[:, 0]), gated.set_aside)
    true = identify(clean_record, order=2, robust=False).judged.track.means @ found.fitted.plant.C.T
    def error(judged):
        return float(np.sqrt(np.mean((judged.track.means @ found.fitted.plant.C.T - true)[half:] ** 2)))
    assert error(gated) < 0.3 * error(plain)


def test_a_gate_sets_aside_its_share_of_good_rows_and_the_mean_nis_allows_for_it() -> None:
    shares, means, plain = [], [], []
    for seed in range(6):
        found = identify(PLANTS[3].record(seed), order=2, robust=False)
        gated = filter_record(found.fitted, found.record, found.judged.first, gate=0.95)
        shares.append(gated.set_aside[found.judged.first:].mean())
        means.append(gated.mean_nis)
        plain.append(found.judged.mean_nis)
    assert np.mean(shares) == pytest.approx(0.05, abs=0.01)
    assert np.mean(means) == pytest.approx(np.mean(plain), abs=0.03)
    with pytest.raises(EngineError, match="gate"):
        filter_record(found.fitted, found.record, found.judged.first, gate=0.2)


@pytest.mark.parametrize("gaps", [False, True], ids=["whole", "gaps"])
def test_a_fit_tells_its_share_and_ends_where_whoever_hears_raises(gaps: bool) -> None:
    record, heard = PLANTS[0].record(1), []
    if gaps:
        record = missing(record, PLANTS[0], np.random.default_rng(0))
    plain = identify(record)
    told = identify(record, progress=heard.append)
    np.testing.assert_array_equal(told.subspace.poles, plain.subspace.poles)
    assert heard[0] == 0 and heard[-1] == 1 and heard == sorted(heard) and max(np.diff(heard)) < 0.5

    class Enough(Exception):
        pass

    def stop(share: float) -> None:
        if share > 0.2:
            raise Enough
    with pytest.raises(Enough):
        identify(record, progress=stop)
