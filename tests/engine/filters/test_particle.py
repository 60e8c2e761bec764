"""The particle filter beside Kalman's filter, and beside Bayes' rule on a grid where the belief has two peaks."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.engine import EngineError, KalmanFilter, ParticleFilter
from observer_lab.engine.filters import ParticleTrack

A, C = np.array([[0.9, 0.2], [0.0, 0.8]]), np.array([[1.0, 0.0]])
Q, R, P0 = np.diag([0.1, 0.2]), np.array([[0.3]]), np.eye(2)


def linear(particles: int) -> ParticleFilter:
    return ParticleFilter(lambda x, u: A @ x, lambda x, u: C @ x, Q, R, particles)


def record() -> np.ndarray:
    y = np.random.default_rng(5).standard_normal((20, 1))
    y[7] = np.nan
    return y


def test_on_a_linear_plant_it_nears_kalman_with_the_root_of_the_particles() -> None:
    y, kf = record(), KalmanFilter(A, np.zeros((2, 1)), C, Q, R)
    exact = kf.run((np.zeros(2), P0), y)
    errors = []
    for particles in (200, 3200):
        runs = [linear(particles).run((np.zeros(2), P0), y, rng=np.random.default_rng(seed)) for seed in range(10)]
        errors.append(np.sqrt(np.mean([np.square(run.means - exact.means) for run in runs])))
        if particles == 3200:
            mean_P = np.mean([run.covariances for run in runs], axis=0)
            np.testing.assert_allclose(mean_P, exact.covariances, atol=0.02)
    # 3200 independent samples of variance 1 would err by 0.018; weights and resampling cost a third more: 0.021 to 0.025 in forty seeds
    assert errors[1] < 0.027 and 2.5 < errors[0] / errors[1] < 6.5  # √16 = 4


def test_it_follows_both_peaks_that_a_squared_measurement_leaves() -> None:
    """x⁺ = 0.9 x + w, y = x² + v: Bayes' rule by sums over a fine grid."""
    grid, y, q, r = np.linspace(-6, 6, 1201), [1.5, 2.5, 2.0, 3.0], 0.2, 0.5
    density = np.exp(-np.square(grid - 0.3) / 2)
    moves = np.exp(-np.square(grid[:, None] - 0.9 * grid) / (2 * q))
    for k, value in enumerate(y):
        density = (moves @ density if k else density) * np.exp(-np.square(value - grid**2) / (2 * r))
    density /= density.sum()
    pf = ParticleFilter(lambda x, u: 0.9 * x, lambda x, u: x**2, [[q]], [[r]], 40_000)
    found = pf.run(([0.3], 1.0), y, rng=np.random.default_rng(1))
    assert found.means[-1, 0] == pytest.approx(density @ grid, abs=0.05)
    right = found.weights[found.particles[0] > 0].sum()
    assert right == pytest.approx(density[grid > 0].sum(), abs=0.02) and 0.1 < right < 0.95


def test_one_seed_gives_one_answer_and_inputs_act() -> None:
    def run(seed: int, push: float) -> ParticleTrack:
        pf = ParticleFilter(lambda x, u: 0.5 * x + u, lambda x, u: x, np.eye(1) * 0.01, np.eye(1) * 100.0, 500)
        return pf.run(([0.0], 0.01), np.zeros(6), np.full((6, 1), push), rng=np.random.default_rng(seed))

    np.testing.assert_array_equal(run(1, 0.0).means, run(1, 0.0).means)
    assert (run(1, 0.0).means != run(2, 0.0).means).any()
    assert run(1, 1.0).means[-1, 0] == pytest.approx(2 * (1 - 0.5**5), abs=0.05)


def test_a_measurement_beyond_all_particles_does_not_end_in_nan() -> None:
    found = linear(50).run((np.zeros(2), P0), [1e6, 0.0], rng=np.random.default_rng(0))
    assert np.isfinite(found.means).all() and found.effective[0] == pytest.approx(1.0)


def test_what_is_given_wrongly_is_named() -> None:
    with pytest.raises(EngineError, match="R must be positive definite"):
        ParticleFilter(lambda x, u: x, lambda x, u: x, np.eye(1), np.zeros((1, 1)))
    with pytest.raises(EngineError, match="f gave NaN"):
        ParticleFilter(lambda x, u: x * np.nan, lambda x, u: x, np.eye(1), np.eye(1)).run(([0.0], 1.0), [0.0, 0.0],
                                                                                        rng=np.random.default_rng(0))
    with pytest.raises(EngineError, match=r"start must be a Belief; an array of shape \(2,\) was given"):
        linear(10).run(np.zeros(2), [0.0], rng=np.random.default_rng(0))
