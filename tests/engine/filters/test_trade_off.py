"""What observers of different belief do with noise: Lyapunov's equation, and a floor that none goes below."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_lyapunov

from observer_lab.engine import EngineError, Plant, Scenario, ShapeError, dlqe, error_parts, lqe, nis, simulate
from observer_lab.engine.filters import growing_error, noise_ladder, simulate_filter

BELIEFS = np.logspace(-2, 2, 5)


def plant_of(seed: int, n: int, dt: float) -> Plant:
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    if dt:
        A *= 1.05 / np.abs(np.linalg.eigvals(A)).max()
    return Plant(A, rng.standard_normal((n, 2)), rng.standard_normal((2, n)), None, dt)


@settings(max_examples=40, derandomize=True, database=None)
@given(st.integers(0, 10_000), st.integers(1, 8), st.sampled_from([0.0, 0.1]))
def test_no_belief_beats_the_truth(seed: int, n: int, dt: float) -> None:
    """P_i − P ⪰ 0 with P the solution of the Riccati equation, which is what the ladder's middle must be."""
    plant, W, V = plant_of(seed, n, dt), np.diag([1.0, 0.5]), np.diag([0.1, 0.3])
    ladder = noise_ladder(plant, plant.B, W, V, BELIEFS)
    least = (dlqe if dt else lqe)(plant.A, plant.B, plant.C, W, V).solution
    size = np.abs(least).max()
    assert np.abs(ladder.parts[2].total - least).max() < 1e-6 * size
    for part in ladder.parts:
        assert np.linalg.eigvalsh(part.total - least)[0] > -1e-7 * size


@settings(max_examples=40, derandomize=True, database=None)
@given(st.integers(0, 10_000), st.integers(1, 8), st.sampled_from([0.0, 0.1]))
def test_each_part_solves_its_own_lyapunov_equation(seed: int, n: int, dt: float) -> None:
    plant, W, V = plant_of(seed, n, dt), np.eye(2), 0.2 * np.eye(2)
    L = (dlqe if dt else lqe)(plant.A, plant.B, plant.C, W, V).gain
    F, parts = plant.A - L @ plant.C, error_parts(plant, L, plant.B, W, V)
    for P, Q in ((parts.process, plant.B @ plant.B.T), (parts.sensor, 0.2 * L @ L.T)):
        rest = F @ P @ F.T - P + Q if dt else F @ P + P @ F.T + Q
        assert np.abs(rest).max() < 1e-8 * max(np.abs(P).max() * max(1.0, np.abs(F).max()), np.abs(Q).max())
        if dt:
            assert np.abs(P - solve_discrete_lyapunov(F, Q)).max() < 1e-7 * np.abs(P).max()


def test_a_scalar_by_hand() -> None:
    """ẋ = −x + w, L = 3: P_w = W/(2·4), P_v = 9 V/(2·4)."""
    parts = error_parts(Plant(np.array([[-1.0]]), np.eye(1), np.eye(1)), [[3.0]], [[1.0]], [[2.0]], [[0.5]])
    assert parts.process == pytest.approx(0.25) and parts.sensor == pytest.approx(9 * 0.5 / 8)
    assert parts.total == pytest.approx(0.25 + 9 / 16)


def test_an_error_that_does_not_settle_has_no_variance() -> None:
    for A, dt in ((np.eye(1), 0.0), (np.zeros((1, 1)), 0.0), (np.eye(1), 0.1)):
        with pytest.raises(EngineError, match="does not settle"):
            error_parts(Plant(A, np.eye(1), np.eye(1), None, dt), [[0.0]], [[1.0]], [[1.0]], [[1.0]])


@pytest.mark.slow
def test_the_growing_variance_is_that_of_many_simulated_runs_and_ends_at_its_limit() -> None:
    plant, W, V, dt = plant_of(4, 3, 0.0), 0.3 * np.eye(2), 0.05 * np.eye(2), 0.02
    stable = Plant(plant.A - 3 * np.eye(3), plant.B, plant.C)
    L = lqe(stable.A, stable.B, stable.C, W, V).gain
    parts, rows = error_parts(stable, L, stable.B, W, V), np.eye(3)
    grown = np.diagonal(growing_error(stable, L, parts, V, dt, rows, 301), axis1=1, axis2=2)
    assert grown[0] == pytest.approx(0.0, abs=1e-12)
    assert np.all(np.abs(grown[-1] / np.diag(parts.total) - 1) < 0.1)  # v held over a step is a little more than white
    square = np.zeros((301, 3))
    for seed in range(400):
        square += simulate(Scenario(stable, None, L, x0=np.zeros(3), xhat0=np.zeros(3), horizon=6.0, dt=dt, W=W, V=V, G=stable.B,
                                    seed=seed)).e ** 2 / 400
    assert np.all(np.abs(square[-1] / grown[-1] - 1) < 5 * np.sqrt(2 / 400))


@pytest.mark.slow
def test_a_filter_on_trial_that_knows_the_truth_expects_as_many_as_it_reads() -> None:
    plant = plant_of(2, 4, 0.0)
    found = simulate_filter(plant, plant.B, np.eye(2), 0.1 * np.eye(2), 0.05, 200, seed=3)
    assert found.expected == pytest.approx(2.0, rel=1e-6) and found.distance[-1] < 1e-2 < found.distance[0]
    for believed in ((0.01, 1.0), (100.0, 1.0), (1.0, 0.1), (1.0, 10.0)):
        many = [simulate_filter(plant, plant.B, np.eye(2), 0.1 * np.eye(2), 0.05, 200, believed=believed,
                                seed=seed) for seed in range(30)]
        means = [float(nis(t.track.innovations[60:], t.track.S[60:]).mean) for t in many]
        assert abs(np.mean(means) / many[0].expected - 1) < 5 * np.std(means) / np.sqrt(30) / many[0].expected + 0.02


def test_covariances_are_covariances_and_shapes_are_told() -> None:
    plant = plant_of(4, 3, 0.0)
    stable, L = Plant(plant.A - 3 * np.eye(3), plant.B, plant.C), np.zeros((3, 2))
    with pytest.raises(EngineError, match="negative eigenvalue"):  # gave a negative covariance
        error_parts(stable, L, np.eye(3), -np.eye(3), np.eye(2))
    for wrong in ((np.eye(2), np.eye(3), np.eye(3)), (L, np.eye(2), np.eye(2)), (L, np.eye(3), np.eye(2))):
        with pytest.raises(ShapeError):
            error_parts(stable, *wrong, np.eye(2))
    parts = error_parts(stable, L, np.eye(3), 1.0, 1.0)
    with pytest.raises(ShapeError, match="rows must have 3 columns"):
        growing_error(stable, L, parts, 1.0, 0.1, np.eye(2), 5)


def test_a_sampled_plant_is_tried_at_its_own_period() -> None:
    """Another step was taken for the period: the time of the run was wrong, and of its kick."""
    plant = Plant([[0.9]], [[1.0]], [[1.0]], None, 0.1)
    with pytest.raises(EngineError, match=r"sampled every 0\.1 s"):
        simulate_filter(plant, plant.B, 1.0, 1.0, 0.3, 50)
