"""Maps of the starts that come home."""

import numpy as np
import pytest

from observer_lab.engine import EngineError, Plant, Scenario, simulate
from observer_lab.engine.simulation import simulate_recovery, simulate_starts, starts_of

FALLING = Plant([[0, 1], [1, 0]], [[0], [1]], [[1, 0]])
K, L = np.array([[5.0, 4.0]]), np.array([[12.0], [37.0]])
ONE = {"u_min": -1, "u_max": 1}


def last(scenario: Scenario, *axes, **more):
    *_, (fraction, result) = simulate_recovery(scenario, *axes, **more)
    assert fraction == 1.0
    return result


def test_region_of_a_scalar_unstable_plant_is_the_interval_theory_gives() -> None:
    plant = Plant([[1.0]], [[1.0]], [[1.0]])  # ẋ = x + sat(u): home exactly from |x| < 1
    s = Scenario(plant, K=[[3.0]], L=[[5.0]], state_feedback=True, horizon=20, **ONE)
    x = np.array([-1.2, -1.001, -0.999, -0.5, 0.0, 0.9, 0.999, 1.001, 3.0])
    result = last(s, 0, x, 0, [-1.0, 0.0, 1.0])
    assert np.array_equal(result.recovered, np.repeat(np.abs(x)[:, None] < 1, 3, axis=1))
    assert np.all(np.isfinite(result.settling) == result.recovered)


@pytest.mark.parametrize("more", [
    {}, {"fed": "commanded"}, {"delay": 0.05}, {"delay": 0.05, "fed": "commanded"}, {"sampled": True},
    {"sampled": True, "delay": 0.03}, {"W": 1e-3, "V": 1e-4, "impulses": ((1.013, [0.1, 0.2]), (2, [0.1, 0]))}])
def test_every_start_runs_as_it_would_alone(more: dict) -> None:
    s = Scenario(FALLING, K, L, horizon=2, **ONE, **more)
    starts = np.random.default_rng(0).uniform(-0.5, 0.5, (6, 4))
    together = np.array(list(simulate_starts(s, starts)))
    for i, start in enumerate(starts):
        run = simulate(Scenario(FALLING, K, L, horizon=2, x0=start[:2], xhat0=start[2:], **ONE, **more))
        count = len(run.t)
        scale = np.abs(run.x).max()
        assert np.abs(np.hstack([run.x, run.xhat]) - together[:count, i]).max() < 1e-11 * scale


def test_two_inputs_and_a_stiff_observer_run_as_they_would_alone() -> None:
    plant = Plant([[0, 1], [2, 0]], np.eye(2), [[1, 0]])
    gain, observer = np.array([[2.0, 1.0], [4.0, 3.0]]), np.array([[400.0], [4e4]])
    limits = {"u_min": [-1, -0.5], "u_max": [0.7, 1], "horizon": 1.0, "dt": 0.02}
    starts = np.random.default_rng(1).uniform(-1, 1, (8, 4))
    together = np.array(list(simulate_starts(Scenario(plant, gain, observer, **limits), starts)))
    for i, start in enumerate(starts):
        run = simulate(Scenario(plant, gain, observer, x0=start[:2], xhat0=start[2:], **limits))
        assert np.abs(run.x - together[:, i, :2]).max() < 1e-10


def test_map_agrees_with_single_runs_and_depends_on_the_estimate() -> None:
    x, e = np.linspace(-1, 1, 7), np.linspace(-0.8, 0.8, 5)
    result = last(Scenario(FALLING, K, L, horizon=8, **ONE), 0, x, 0, e)
    for i, a in enumerate(x):
        for j, b in enumerate(e):
            run = simulate(Scenario(FALLING, K, L, x0=[a, 0], xhat0=[a - b, 0], horizon=8, **ONE))
            home = run.diverged_at is None and np.linalg.norm(run.x[-1]) < result.threshold
            assert result.recovered[i, j] == home
            if home:
                out = np.flatnonzero(np.linalg.norm(run.x, axis=1) >= result.threshold)
                assert result.settling[i, j] == pytest.approx(0 if not len(out) else run.t[out[-1]] + 0.01)
    assert 0 < result.recovered.sum() < result.recovered.size
    assert any(len(set(row)) == 2 for row in result.recovered.tolist())  # the same x(0), another e(0)


def test_unlimited_stable_loop_always_recovers() -> None:
    assert last(Scenario(FALLING, K, L, horizon=8), 0, [-5, 0, 5], 1, [-5, 5]).recovered.all()


def test_a_start_beyond_the_bound_is_lost_for_good() -> None:
    s = Scenario(FALLING, K, L, x0=[1, 0], xhat0=[0, 0], horizon=8)
    peak = np.linalg.norm(simulate(s).x, axis=1).max()
    assert last(s, 0, [1.0], 0, [1.0], bound=1.01 * peak).recovered.all()
    assert not last(s, 0, [1.0], 0, [1.0], bound=0.99 * peak).recovered.any()


def test_progress_comes_in_slices_and_rises_to_one() -> None:
    steps = list(simulate_recovery(Scenario(FALLING, K, L, horizon=1, **ONE), 0, [-1, 0, 1], 0, [0, 1],
                                   slice_seconds=0.0))
    fractions = [fraction for fraction, _ in steps]
    assert len(fractions) == 101 and fractions == sorted(fractions) and fractions[-1] == 1.0
    assert all(part.recovered.shape == (3, 2) for _, part in steps)


def test_starts_put_the_error_between_state_and_estimate() -> None:
    s = Scenario(FALLING, K, L, x0=[0.0, 0.3], xhat0=[0.0, 0.1])
    starts = starts_of(s, 0, np.array([1.0, 2.0]), 1, np.array([5.0]))
    assert np.allclose(starts, [[1, 0.3, 1, -4.7], [2, 0.3, 2, -4.7]])


@pytest.mark.parametrize("axes", [(2, [0.0], 0, [0.0]), (0, [np.nan], 0, [0.0]), (0, [], 0, [0.0]),
                                  (0, np.zeros(1000), 0, np.zeros(1000))])
def test_impossible_maps_are_refused(axes: tuple) -> None:
    with pytest.raises(EngineError):
        next(simulate_recovery(Scenario(FALLING, K, L), *axes))
