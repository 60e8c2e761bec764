"""Inputs without a cost, sensors without noise: beside the recursions that the equations are the limit of."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.engine import EngineError, KalmanFilter, RiccatiError, dlqe, dlqr, lqr


def case(seed: int) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    n, m = rng.integers(2, 5), rng.integers(1, 3)
    A, B, M = rng.standard_normal((n, n)), rng.standard_normal((n, m)), rng.standard_normal((n, n))
    R = np.diag([0.0, 1.0][:m]) if seed % 2 else np.zeros((m, m))
    return A, B, M @ M.T + 0.1 * np.eye(n), R


@pytest.mark.parametrize("unit", [1.0, 1e-6])
def test_dlqr_is_the_limit_of_the_recursion_backwards(unit: float) -> None:
    for seed in range(30):
        A, B, Q, R = case(seed)
        x = np.ones(len(A))
        x[0] = unit
        A, B, Q = A * x / x[:, None], B / x[:, None], Q * x * x[:, None]
        S = Q
        for _ in range(400):
            K = np.linalg.solve(R + B.T @ S @ B, B.T @ S @ A)
            S = Q + A.T @ S @ (A - B @ K)
            S = (S + S.T) / 2
        found = dlqr(A, B, Q, R)
        np.testing.assert_allclose(found.gain * x, K * x, rtol=1e-7, atol=1e-9 * np.abs(K * x).max())
        assert np.abs(found.poles).max() < 1
        # A mode that the input hardly reaches makes S up to 1e6 times Q (seed 18); the terms of the equation then cancel that far.
        size = np.linalg.norm(found.solution / x / x[:, None]) / np.linalg.norm(Q / x / x[:, None])
        assert found.residual < 1e-15 + 1e-18 * size


def test_dlqe_of_sensors_without_noise_is_what_the_filter_settles_at() -> None:
    for seed in range(20):
        A, B, Q, R = case(seed)
        found = dlqe(A.T, np.eye(len(A)), B.T, Q, R)
        P = found.solution
        kf = KalmanFilter(A.T, np.zeros((len(A), 1)), B.T, Q, R)
        schedule = kf.schedule(kf.run(np.zeros((1, len(R)))).last, 200)
        np.testing.assert_allclose(schedule.gains[-1], found.filter_gain, atol=1e-7)
        silent = np.flatnonzero(np.diag(R) == 0)
        after = found.filtered[np.ix_(range(len(A)), range(len(A)))]
        np.testing.assert_allclose(B.T[silent] @ after, 0.0, atol=1e-10 * np.abs(P).max())  # what is measured exactly is known


def test_without_a_cost_one_input_makes_the_first_output_of_two_states_vanish_at_once() -> None:
    """Q = CᵀC, R = 0: u = −(CB)⁻¹CA x puts y to zero, and the pole left is the zero of the plant, here 0.5."""
    A, B, C = np.array([[1.2, 1.0], [0.0, 0.7]]), np.array([[1.0], [0.2]]), np.array([[1.0, 0.0]])
    found = dlqr(A, B, C.T @ C, [[0.0]])
    np.testing.assert_allclose(found.gain, C @ A / (C @ B), atol=1e-12)
    np.testing.assert_allclose(found.poles, [0.0, 0.7 - 0.2], atol=1e-12)


def test_where_the_equation_has_no_answer_it_is_said() -> None:
    with pytest.raises(RiccatiError, match="singular R"):
        dlqr(np.eye(2) / 2, np.eye(2), np.diag([1.0, 0.0]), np.zeros((2, 2)))
    with pytest.raises(RiccatiError, match="singular R"):
        dlqr([[2.0]], [[0.0]], [[1.0]], [[0.0]])
    with pytest.raises(EngineError, match="R must be positive definite"):
        lqr([[0.0]], [[1.0]], [[1.0]], [[0.0]])
    with pytest.raises(EngineError, match="negative"):
        dlqr([[0.5]], [[1.0]], [[1.0]], [[-1.0]])
