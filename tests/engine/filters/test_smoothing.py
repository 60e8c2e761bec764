"""The smoother beside FilterPy and the batch solution; the moving horizon beside Kalman's filter and bounded least squares."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter as Peer
from scipy.optimize import lsq_linear

from observer_lab.engine import EngineError, KalmanFilter, SquareRootFilter, moving_horizon, smooth
from observer_lab.engine.systems import root

RNG_SEEDS = range(12)


def case(seed: int, steps: int = 25) -> tuple[KalmanFilter, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    n, m, p = rng.integers(1, 4), 1, rng.integers(1, 3)
    A = rng.standard_normal((n, n))
    A *= 0.95 / max(1e-3, np.abs(np.linalg.eigvals(A)).max())
    Q, R, P = (M @ M.T + 0.1 * np.eye(k) for k in (n, p, n) for M in [rng.standard_normal((k, k))])
    kf = KalmanFilter(A, rng.standard_normal((n, m)), rng.standard_normal((p, n)), Q, R)
    u = rng.standard_normal((steps, m))
    x, y = root(P) @ rng.standard_normal(n), np.empty((steps, p))
    for k in range(steps):
        y[k] = kf.C @ x + root(R) @ rng.standard_normal(p)
        x = A @ x + kf.B @ u[k] + root(Q) @ rng.standard_normal(n)
    return kf, P, y, u, rng.random((steps, p)) < 0.2


def batch(kf: KalmanFilter, P: np.ndarray, y: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weighted least squares for all states at once: matrix M and right side b, one row a residual of unit variance."""
    steps, n = len(y), kf.n
    rows, right = [np.hstack([np.linalg.inv(root(P)), np.zeros((n, n * (steps - 1)))])], [np.zeros(n)]
    for k in range(steps):
        seen = np.isfinite(y[k])
        at = np.zeros((n, n * steps))
        at[:, n * k:n * (k + 1)] = np.eye(n)
        if seen.any():
            weight = np.linalg.inv(np.linalg.cholesky(kf.R[np.ix_(seen, seen)]))
            rows.append(weight @ kf.C[seen] @ at)
            right.append(weight @ y[k, seen])
        if k + 1 < steps:
            ahead = np.zeros((n, n * steps))
            ahead[:, n * (k + 1):n * (k + 2)] = np.eye(n)
            weight = np.linalg.inv(root(kf.Q))
            rows.append(weight @ (ahead - kf.A @ at))
            right.append(weight @ kf.B @ u[k])
    return np.vstack(rows), np.concatenate(right)


@pytest.mark.parametrize("seed", RNG_SEEDS)
def test_smoother_is_the_batch_solution_with_gaps_and_inputs(seed: int) -> None:
    kf, P, y, u, lost = case(seed)
    y = np.where(lost, np.nan, y)
    found = smooth(kf, kf.run((np.zeros(kf.n), P), y, u))
    M, b = batch(kf, P, y, u)
    P_all = np.linalg.inv(M.T @ M)
    np.testing.assert_allclose(found.means.ravel(), P_all @ (M.T @ b), atol=1e-9)
    for k in (0, 7, len(y) - 1):
        here = slice(kf.n * k, kf.n * (k + 1))
        np.testing.assert_allclose(found.covariances[k], P_all[here, here], atol=1e-10)


def test_smoother_agrees_with_filterpy_on_a_long_settled_record() -> None:
    kf, P, y, _, _ = case(3, steps=300)
    track = kf.run((np.zeros(kf.n), P), y)
    peer = Peer(kf.n, len(kf.C))
    peer.F, peer.H, peer.Q, peer.R = kf.A, kf.C, kf.Q, kf.R
    means, covariances, _, _ = peer.rts_smoother(track.means[..., None], track.covariances)
    found = smooth(kf, track)
    assert track.settled is not None
    np.testing.assert_allclose(found.means, means[..., 0], atol=1e-8)
    np.testing.assert_allclose(found.covariances, covariances, atol=1e-8)


def test_smoother_never_knows_less_than_the_filter_and_ends_with_it() -> None:
    for seed in RNG_SEEDS:
        kf, P, y, _, _ = case(seed)
        track = kf.run((np.zeros(kf.n), P), y)
        found = smooth(kf, track)
        assert (found.variances <= track.variances + 1e-12).all()
        np.testing.assert_array_equal(found.means[-1], track.means[-1])


def test_smoother_leaves_what_is_certain_as_it_is() -> None:
    kf = SquareRootFilter(np.eye(2), np.zeros((2, 1)), [[1.0, 1.0]], np.diag([1.0, 0.0]), 1.0)
    found = smooth(kf, kf.run(([0.0, 2.0], np.diag([1.0, 0.0])), [1.0, 4.0, 2.0, 5.0]))
    np.testing.assert_allclose(found.means[:, 1], 2.0)
    np.testing.assert_allclose(found.covariances[:, 1, 1], 0.0, atol=1e-15)


def test_smoother_refuses_the_track_of_another_model() -> None:
    one, two = (KalmanFilter(np.eye(n) / 2, np.zeros((n, 1)), np.eye(n), np.eye(n), np.eye(n)) for n in (1, 2))
    with pytest.raises(EngineError, match="2 states"):
        smooth(one, two.run(np.zeros((3, 2))))


@pytest.mark.parametrize("horizon", [1, 3, 10, 40])
def test_without_bounds_the_moving_horizon_is_the_kalman_filter(horizon: int) -> None:
    for seed in range(3):
        kf, P, y, u, lost = case(seed)
        y = np.where(lost, np.nan, y)
        found = moving_horizon(kf, y, u, start=(np.zeros(kf.n), P), horizon=horizon)  # type: ignore[arg-type]
        np.testing.assert_allclose(found.means, kf.run((np.zeros(kf.n), P), y, u).means, atol=1e-8)
        assert not found.bounded.any()


@pytest.mark.parametrize("seed", RNG_SEEDS)
def test_with_bounds_the_whole_record_is_bounded_least_squares(seed: int) -> None:
    kf, P, y, u, _ = case(seed, steps=12)
    lower, upper = -0.5, 0.7
    found = moving_horizon(kf, y, u, start=(np.zeros(kf.n), P), lower=lower, upper=upper, horizon=12)  # type: ignore[arg-type]
    assert found.bounded.any()
    assert (found.means >= lower - 1e-7).all() and (found.means <= upper + 1e-7).all()
    for k in (4, 11):
        M, b = batch(kf, P, y[:k + 1], u[:k + 1])
        best = lsq_linear(M, b, (lower, upper), tol=1e-13).x
        np.testing.assert_allclose(found.means[k], best[-kf.n:], atol=2e-5)


@pytest.mark.parametrize("seed", RNG_SEEDS)
def test_bounds_hold_in_any_units(seed: int) -> None:
    kf, P, y, u, lost = case(seed, steps=12)
    rng = np.random.default_rng(seed)
    y, low, high = np.where(lost, np.nan, y), np.full(kf.n, -0.5), np.full(kf.n, 0.7)
    own = moving_horizon(kf, y, u, start=(np.zeros(kf.n), P), lower=low, upper=high, horizon=5)  # type: ignore[arg-type]
    for decades in (-9, 9, 0):
        X, Y, U = (10.0 ** (decades if decades else rng.uniform(-9, 9, k)) * np.ones(k) for k in (kf.n, len(kf.C), 1))
        other = KalmanFilter(kf.A * X / X[:, None], kf.B * U / X[:, None], kf.C * X / Y[:, None], kf.Q / np.outer(X, X),
                             kf.R / np.outer(Y, Y))
        found = moving_horizon(other, y / Y, u / U, start=(np.zeros(kf.n), P / np.outer(X, X)), lower=low / X,  # type: ignore[arg-type]
                               upper=high / X, horizon=5)
        np.testing.assert_allclose(found.means * X, own.means, atol=1e-7)
        assert own.bounded.any() and (found.bounded == own.bounded).all()


def test_a_noise_free_state_keeps_its_bounds_in_the_moving_horizon() -> None:
    kf = KalmanFilter([[1.0, 1.0], [0.0, 1.0]], np.zeros((2, 1)), [[1.0, 0.0]], np.diag([1.0, 0.0]), 1.0)
    y = -0.3 * np.arange(12.0)
    found = moving_horizon(kf, y, start=([0.0, 0.0], np.eye(2)), lower=[-np.inf, -0.1])  # type: ignore[arg-type]
    assert found.means[-1, 1] == pytest.approx(-0.1, abs=1e-7) and found.bounded[-1]


def test_bounds_that_no_state_meets_are_refused() -> None:
    kf = KalmanFilter([[1.0]], [[0.0]], [[1.0]], 0.0, 1.0)
    with pytest.raises(EngineError, match="within the bounds"):
        moving_horizon(kf, [0.0, 0.0], start=([0.0], 0.0), lower=1.0)  # type: ignore[arg-type]
    with pytest.raises(EngineError, match="exchange"):
        moving_horizon(kf, [0.0], start=([0.0], 0.0), lower=1.0, upper=0.0)  # type: ignore[arg-type]


def test_without_the_solver_bounds_are_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "daqp", None)
    kf = KalmanFilter([[1.0]], [[0.0]], [[1.0]], 1.0, 1.0)
    assert moving_horizon(kf, [1.0], lower=0.0).means[0, 0] > 0
    with pytest.raises(EngineError, match="pip install"):
        moving_horizon(kf, [-1.0], lower=0.0)
