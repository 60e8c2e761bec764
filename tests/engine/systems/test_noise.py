"""Noise has the covariance the theory gives, at any step length."""

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm, solve_continuous_lyapunov, solve_discrete_lyapunov

from observer_lab.engine import Plant, Scenario, simulate
from observer_lab.engine.systems import process_noise, root, step_covariance

DOUBLE = Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
K, L = np.array([[4.0, 4.0]]), np.array([[12.0], [36.0]])


def test_scalar_covariance_in_closed_form() -> None:
    for a, h in ((-2.0, 0.1), (3.0, 0.2), (-1e6, 1.0), (-1e-9, 1e-3)):
        true = np.expm1(2 * a * h) / (2 * a)
        assert step_covariance(np.array([[a]]), np.eye(1), h)[0, 0] == pytest.approx(true, rel=1e-9)


def test_covariance_at_half_a_period_is_the_integral_not_the_rectangle() -> None:
    A, Q, h = np.array([[0.0, 1], [-np.pi**2, -0.1]]), np.diag([0.0, 2.0]), 1.0
    true, _ = quad_vec(lambda s: expm(A * s) @ Q @ expm(A * s).T, 0, h, epsabs=1e-13)
    assert np.allclose(step_covariance(A, Q, h), true, atol=1e-11)
    assert abs(true[1, 1] - 2.0 * h) > 0.9  # what G W Gᵀ dt would have given


def test_stiff_plant_does_not_overflow() -> None:
    A = np.array([[-4e5, 1.0], [0.0, -1e-4]])
    Q = step_covariance(A, np.eye(2), 10.0)
    true = solve_continuous_lyapunov(A, -np.eye(2) + expm(A * 10) @ expm(A * 10).T)
    assert np.allclose(Q, true, rtol=1e-6, atol=1e-12)


def test_increments_make_the_stationary_covariance_of_the_continuous_plant() -> None:
    A = np.array([[-1.0, 2.0], [-2.0, -0.5]])
    h = 1.5
    Q = step_covariance(A, np.eye(2), h)
    assert np.allclose(solve_discrete_lyapunov(expm(A * h), Q), solve_continuous_lyapunov(A, -np.eye(2)), atol=1e-12)


def test_draws_have_the_joint_covariance_of_jump_and_mean() -> None:
    A, G, W, h = np.array([[0.0, 1.0], [-9.0, -0.2]]), np.array([[0.0], [1.0]]), np.array([[2.0]]), 0.7
    w, jumps = process_noise(A, G, W, h, 200_000, np.random.default_rng(3))
    spread = np.cov(np.hstack([jumps, w]).T)
    jump_on_mean, _ = quad_vec(lambda s: expm(A * s) @ G @ W / h, 0, h)
    true = np.block([[step_covariance(A, G @ W @ G.T, h), jump_on_mean], [jump_on_mean.T, W / h]])
    deviation = np.sqrt(np.diag(true))
    assert np.abs((spread - true) / np.outer(deviation, deviation)).max() < 5 * np.sqrt(2 / 200_000)


def test_root_of_badly_scaled_and_singular_covariances() -> None:
    factor = np.array([[1e6, 0.0], [3e-9, 4e-9], [0.0, 0.0]])
    covariance = factor @ factor.T
    again = root(covariance) @ root(covariance).T
    assert np.allclose(again, covariance, rtol=1e-12, atol=0)


def test_measurement_noise_has_density_v_whatever_the_step() -> None:
    for dt in (0.01, 0.1):
        run = simulate(Scenario(DOUBLE, K, L, V=4.0, dt=dt, horizon=20_000 * dt))
        assert np.var(run.v) * dt == pytest.approx(4.0, rel=5 * np.sqrt(2 / 20_000))
        assert np.allclose(run.y - run.x @ DOUBLE.C.T, run.v)


def test_monte_carlo_error_variance_matches_lyapunov() -> None:
    W, V = 0.5, 0.01
    run = simulate(Scenario(DOUBLE, K, L, W=W, V=V, dt=0.01, horizon=4000, seed=11))
    A = DOUBLE.A - L @ DOUBLE.C
    P = solve_continuous_lyapunov(A, -(DOUBLE.B @ DOUBLE.B.T * W + L @ L.T * V))
    measured = run.e[500:].T @ run.e[500:] / len(run.e[500:])
    assert np.allclose(measured, P, rtol=0.06)  # about 4000 s × 6/s / 2 independent samples: 1.3 % each


def test_same_seed_same_noise_and_designs_share_it() -> None:
    def run(seed: int, gain: np.ndarray):
        return simulate(Scenario(DOUBLE, K, gain, W=1.0, V=1.0, seed=seed, horizon=1))

    one, other, faster = run(4, L), run(5, L), run(4, 2 * L)
    assert np.array_equal(one.x, run(4, L).x) and not np.allclose(one.w, other.w)
    assert np.array_equal(one.w, faster.w) and np.array_equal(one.v, faster.v)
    alone = simulate(Scenario(DOUBLE, K, L, V=1.0, seed=4, horizon=1))
    assert np.array_equal(alone.v, one.v)


def test_sampled_plant_takes_covariances_of_a_sample() -> None:
    plant = Plant([[0.9]], [[1.0]], [[1.0]], dt=0.1)
    run = simulate(Scenario(plant, W=2.0, V=3.0, dt=0.1, horizon=4000, seed=2))
    assert np.var(run.w) == pytest.approx(2.0, rel=0.04) and np.var(run.v) == pytest.approx(3.0, rel=0.04)
    assert np.allclose(run.x[1:], 0.9 * run.x[:-1] + run.w[:-1])


def test_sampled_loop_on_a_continuous_plant_has_the_exact_plant_noise() -> None:
    plant = Plant([[-1.0]], [[1.0]], [[1.0]])
    run = simulate(Scenario(plant, W=2.0, dt=1.0, horizon=40_000, sampled=True, seed=9))
    assert np.var(run.x) == pytest.approx(1.0, rel=0.04)  # W / 2|a|, whatever dt


def test_a_disturbance_of_a_small_unit_is_still_felt_by_its_own_state() -> None:
    """The mean of the weaker disturbance was drawn apart from what it did where its variance was 1e-16 of the other's."""
    A, W = np.array([[-1.0, 0.0], [0.0, -2.0]]), np.diag([1.0, 1e-18])
    w, jumps = process_noise(A, np.eye(2), W, 0.1, 20_000, np.random.default_rng(3))
    for i in range(2):
        assert np.corrcoef(w[:, i], jumps[:, i])[0, 1] > 0.99
