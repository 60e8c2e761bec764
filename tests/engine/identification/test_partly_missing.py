"""Rows in which only some outputs came: the fit, the likelihood, the NIS and the tests use those that did."""

from __future__ import annotations

import numpy as np
import pytest
from record_laws import PLANTS
from scipy.linalg import solve_discrete_lyapunov

from observer_lab.engine import Belief, KalmanFilter, Plant
from observer_lab.engine.identification import FittedFilter, Record, filter_record, fit_noise, identify
from observer_lab.engine.identification.evidence import evidence_of
from observer_lab.engine.identification.smoother import smooth

TWO_SENSORS = PLANTS[3]


def gaps(kind: str, shape: tuple[int, int]) -> np.ndarray:
    """Which readings are missing."""
    rows, rng = np.arange(shape[0])[:, None], np.random.default_rng(5)
    return {"a tenth": rng.random(shape) < 0.1, "in turn": (rows + np.arange(shape[1])) % 2 == 0,
            "one is slow": (rows % 10 > 0) & (np.arange(shape[1]) == 1),
            "one fails": (rows >= 200) & (rows < 350) & (np.arange(shape[1]) == 1)}[kind]


@pytest.mark.slow
@pytest.mark.parametrize("kind, rows", [("a tenth", 540), ("in turn", 300), ("one is slow", 330), ("one fails", 525)])
def test_poles_and_noises_come_from_all_readings(kind: str, rows: int) -> None:
    record = TWO_SENSORS.record(1)
    found = identify(Record(record.t, record.u, np.where(gaps(kind, record.y.shape), np.nan, record.y)), order=2)
    true = np.sort_complex(np.linalg.eigvals(TWO_SENSORS.sampled()[0]))
    assert found.fitted.rows == pytest.approx(rows, abs=15)
    assert (np.abs(found.subspace.poles - true) < 4 * found.subspace.deviations).all() and found.subspace.deviations.max() < 0.006
    np.testing.assert_allclose(np.diag(found.fitted.R), TWO_SENSORS.r**2, rtol=0.3)
    assert found.judged.nis_holds and found.judged.evidence.stable and found.judged.evidence.open_loop


@pytest.mark.parametrize("kind", ["a tenth", "in turn", "one is slow"])
def test_no_noises_near_the_found_ones_make_all_readings_more_likely(kind: str) -> None:
    """−2 log L by the whole covariance matrix of the readings that came, without any filter."""
    A, C, count = np.array([[0.8, 0.2], [-0.1, 0.7]]), np.array([[1.0, 0.0], [0.5, 1.0]]), 150
    rng = np.random.default_rng(2)
    x, states = np.zeros(2), []
    for _ in range(count):
        states.append(x)
        x = A @ x + 0.3 * rng.standard_normal(2)
    y = np.array(states) @ C.T + (0.4, 0.6) * rng.standard_normal((count, 2))
    seen = ~gaps(kind, y.shape)
    found = fit_noise(Plant(A, np.ones((2, 1)), C, None, 1.0), Record(np.arange(count), np.zeros((count, 1)), np.where(seen, y, np.nan)))
    shrink = (found.rows - 2) / (found.rows + 2)  # what the fit adds for rows to come

    def level(Q: np.ndarray, R: np.ndarray) -> float:
        P, across = solve_discrete_lyapunov(A, Q), [np.linalg.matrix_power(A, k) for k in range(count)]
        S = np.block([[C @ (across[i - j] @ P if i >= j else P @ across[j - i].T) @ C.T + (R if i == j else 0) for j in range(count)]
                      for i in range(count)])[np.ix_(seen.ravel(), seen.ravel())]
        z = y.ravel()[seen.ravel()]
        return float(np.linalg.slogdet(S)[1] + z @ np.linalg.solve(S, z))
    Q, R = shrink * found.Q, shrink * found.R
    best = level(Q, R)
    for g, h, j in ((0.5, 1, 1), (2, 1, 1), (1, 0.7, 1), (1, 1.4, 1), (1, 1, 0.7), (1, 1, 1.4)):
        assert level(g * Q, R * np.diag([h, j])) > best - 0.3
    assert level(Q, 2 * R) > best + 1


def test_the_nis_counts_readings_and_not_rows() -> None:
    """Beside a filter that deletes the rows of C and R whose reading is missing, with the gate and without."""
    A, B, C = TWO_SENSORS.sampled()
    record = TWO_SENSORS.record(2)
    y = np.where(gaps("a tenth", record.y.shape), np.nan, record.y)
    Q, R = TWO_SENSORS.q**2 * B @ B.T, TWO_SENSORS.r**2 * np.eye(2)
    fitted = FittedFilter(Plant(A, B, C, None, TWO_SENSORS.dt), Q, R, 600, 4, 0.0, np.zeros((1, 2)))
    found = filter_record(fitted, Record(record.t, record.u, y), 600)
    x, P = np.zeros(2), found.track.schedule.prior[0]
    sizes, readings = 0.0, 0
    for k, (now, read) in enumerate(zip(record.u, y, strict=True)):
        lost = np.flatnonzero(np.isnan(read))
        Ck, z = np.delete(C, lost, axis=0), np.delete(read, lost)
        S = Ck @ P @ Ck.T + np.delete(np.delete(R, lost, axis=0), lost, axis=1)
        nu, M = z - Ck @ x, P @ Ck.T @ np.linalg.inv(S)
        if k >= 600:
            sizes, readings = sizes + nu @ np.linalg.solve(S, nu), readings + len(z)
        x, P = A @ (x + M @ nu) + B @ now, A @ (P - M @ Ck @ P) @ A.T + Q
    assert found.mean_nis == pytest.approx(sizes / readings, rel=1e-9) and found.nis_holds
    means = [filter_record(fitted, Record(record.t, record.u, y), 600, gate=share).mean_nis for share in (0.95, 0.99)]
    assert means == pytest.approx([found.mean_nis] * 2, abs=0.06)


def test_whole_rows_are_judged_as_before_and_one_reading_less_changes_little() -> None:
    """The tests of the unused rows see a record with one reading missing almost as the whole one."""
    A, B, C = TWO_SENSORS.sampled()
    record = TWO_SENSORS.record(4)
    fitted = FittedFilter(Plant(A, B, C, None, TWO_SENSORS.dt), TWO_SENSORS.q**2 * B @ B.T, TWO_SENSORS.r**2 * np.eye(2), 600, 4, 0.0,
                          np.zeros((1, 2)))
    y = np.array(record.y)
    y[900, 1] = np.nan
    whole, less = (filter_record(fitted, Record(record.t, record.u, each), 600) for each in (record.y, y))
    assert less.mean_nis == pytest.approx(whole.mean_nis, rel=0.01)
    for name in ("white", "input", "feedback", "same_row"):
        assert getattr(less.evidence, name) == pytest.approx(getattr(whole.evidence, name), abs=0.1), name
    assert evidence_of(fitted.kalman(), less.track, Record(record.t, record.u, y), 600, True, less.fit).free_run == less.evidence.free_run


def test_the_smoother_takes_a_singular_covariance() -> None:
    """A sensor without noise of one state, and no process noise on it: what is left is the smoother of the other state alone."""
    A, Q, rng = np.diag([0.9, 0.7]), np.diag([0.0, 0.3]), np.random.default_rng(0)
    y = np.column_stack([np.zeros(40), rng.standard_normal(40)])
    both = KalmanFilter(A, np.zeros((2, 1)), np.eye(2), Q, np.diag([1e-300, 0.5]))
    alone = KalmanFilter([[0.7]], [[0.0]], [[1.0]], [[0.3]], [[0.5]])
    start = Belief([0, 0], np.diag([0.0, 1.0]))
    np.testing.assert_allclose(smooth(both, both.run(start, y)).means[:, 1],
                               smooth(alone, alone.run(Belief([0], [[1.0]]), y[:, 1:])).means[:, 0], atol=1e-12)
