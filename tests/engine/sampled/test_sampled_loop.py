"""The sampled loop against oracles: exact propagation in 40 digits, a plain loop, Lyapunov, scipy."""

from __future__ import annotations

import numpy as np
import pytest
from sampled_platform import (
    BELIEVED,
    CONTROLLER,
    DT,
    GROUND,
    IDEAL,
    KICK,
    PLANT,
    K,
    V,
    W,
    by_definition,
    loop_of,
    scipys,
)
from scipy import signal
from scipy.linalg import solve_continuous_lyapunov

from observer_lab.engine import Belief, EngineError, KalmanFilter, Plant, ShapeError, sampled_loop, simulate_trial
from observer_lab.engine.sampled import Hardware, recursive_controller, response_measures, sampled_controller, simulate_trials
from observer_lab.engine.systems import step_covariance


@pytest.mark.parametrize("hardware", [
    Hardware(), Hardware(bandwidth=80.0), Hardware(bandwidth=60.0, order=2), Hardware(delay=2e-3), Hardware(delay=0.4e-3),
    Hardware(delay=2.3e-3, bandwidth=90.0, order=2, ramp=1e-6, walk=1e-7),
], ids=["ideal", "lag", "lag of second order", "whole delay", "part of a sample", "together"])
def test_a_linear_run_is_exact(hardware: Hardware) -> None:
    steps = 3000
    ground = np.zeros((steps, 2))
    ground[500:] = 1e-5, -2e-5
    run = simulate_trial(loop_of(hardware), steps, seed=7, disturbance=ground, kicks=((100, KICK),))
    states, readings, commands = by_definition(hardware, steps, 7, ground)
    for ours, plain in ((run.x, states), (run.read, readings), (run.applied, commands)):
        assert np.abs(ours - plain).max() <= 1e-12 * np.abs(plain).max()
    assert not run.diverged


@pytest.mark.parametrize("hardware", [
    Hardware(limit=0.1), Hardware(limit=0.004), Hardware(step=2e-6),
    Hardware(limit=0.05, step=1e-6, bandwidth=50.0, order=2, delay=1.5e-3, walk=1e-7, ramp=1e-7),
], ids=["sometimes clipped", "mostly clipped", "rounded", "everything"])
def test_a_clipped_or_rounded_run_equals_the_plain_loop(hardware: Hardware) -> None:
    steps = 3000
    ground = np.zeros((steps, 2))
    ground[500:] = 1e-5, -2e-5
    run = simulate_trial(loop_of(hardware), steps, seed=3, disturbance=ground, kicks=((100, KICK),))
    states, _, commands = by_definition(hardware, steps, 3, ground)
    assert np.abs(run.x - states).max() <= 1e-9 * np.abs(states).max()
    assert np.abs(run.applied - commands).max() <= 1e-9 * np.abs(commands).max()
    if np.isfinite(hardware.limit):
        assert np.abs(run.asked).max() > hardware.limit
        assert np.abs(run.applied).max() == hardware.limit


def test_designs_with_one_plant_feel_one_noise() -> None:
    silent = sampled_controller(Plant(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((3, 0)), np.zeros((3, 4)), DT), DT)
    calm, rough = (simulate_trial(sampled_loop(PLANT, silent, range(3), W=W, V=V, hardware=hardware), 500, seed=9)
                   for hardware in (IDEAL, Hardware(walk=1e-6, bandwidth=50.0, delay=2e-3)))
    assert np.abs(calm.x - rough.x).max() <= 1e-9 * np.abs(calm.x).max()
    other = sampled_loop(PLANT, sampled_controller(CONTROLLER, DT, method="hold"), range(3), W=W, V=V,
                         hardware=Hardware(bandwidth=100.0))
    assert other.jump[3:13].shape == loop_of().jump[:10].shape
    assert np.allclose(other.jump[3:13], loop_of().jump[:10], rtol=1e-9, atol=0)


def test_the_ground_pushes_with_its_exact_covariance() -> None:
    loop, G = loop_of(), PLANT.B[:, 3:]
    exact = step_covariance(PLANT.A, G @ W @ G.T, DT)
    size = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    assert np.abs((loop.jump @ loop.jump.T)[:10, :10] - exact).max() <= 1e-12 * size.max()
    assert np.all(np.abs((loop.jump @ loop.jump.T)[:10, :10] - exact) <= 1e-11 * size)


def test_sampling_leaves_the_variances_of_a_shaped_ground() -> None:
    """Open loop: the stationary covariance at the samples is that of the continuous plant and its ground filter."""
    corner = np.array([2.0, 5.0])
    shaping = Plant(-np.diag(corner), np.diag(np.sqrt(2 * corner)), np.eye(2))
    silent = sampled_controller(Plant(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((3, 0)), np.zeros((3, 4)), DT), DT)
    loop = sampled_loop(PLANT, silent, range(3), W=W, shaping=shaping)
    A = np.block([[PLANT.A, PLANT.B[:, 3:]], [np.zeros((2, 10)), shaping.A]])
    G = np.vstack([np.zeros((10, 2)), shaping.B])
    exact = solve_continuous_lyapunov(A, -G @ W @ G.T)
    size = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    assert np.all(np.abs(loop.covariance - exact) <= 1e-7 * size)


def test_tustin_and_hold_are_scipys() -> None:
    for method, name in (("tustin", "bilinear"), ("hold", "zoh")):
        ours = sampled_controller(CONTROLLER, DT, method=method).last  # type: ignore[arg-type]
        peer = scipys(name)
        for frequency in (0.1, 1.0, 20.0, 300.0):
            z = np.exp(2j * np.pi * frequency * DT)
            one = ours.C @ np.linalg.solve(z * np.eye(ours.n) - ours.A, ours.B) + ours.D
            two = peer[2] @ np.linalg.solve(z * np.eye(ours.n) - peer[0], peer[1]) + peer[3]
            assert np.abs(one - two).max() <= 1e-9 * np.abs(two).max()


@pytest.mark.parametrize("told", ["commanded", "applied"])
def test_the_recursive_controller_is_the_kalman_filter_with_feedback(told: str) -> None:
    """Its commands are −K x̂[k|k] of a filter run over the same readings and the inputs it was told."""
    kf = KalmanFilter.from_plant(BELIEVED, W, V, dt=DT, G=GROUND)
    start = Belief(np.zeros(8), 1e-9 * np.eye(8))
    controller = recursive_controller(kf, 0.2 * K, start, 400, told=told)  # type: ignore[arg-type]
    loop = sampled_loop(PLANT, controller, range(3), W=W, V=V, hardware=Hardware(limit=0.02))
    run = simulate_trial(loop, 400, seed=5, kicks=((50, 0.1 * KICK),))
    assert np.any(run.asked != run.applied)
    track = kf.run(start, run.read, run.applied if told == "applied" else run.asked)
    assert np.abs(run.asked + track.means @ (0.2 * K).T).max() <= 1e-9 * np.abs(run.asked).max()


def test_measures_of_a_step_are_the_textbooks() -> None:
    zeta, t = 0.3, np.arange(0.0, 40.0, 1e-3)
    _, y = signal.step((1.0, (1.0, 2 * zeta, 1.0)), T=t)
    u = np.column_stack([np.full(len(t), 0.5), np.zeros(len(t))])
    found = response_measures(t, y, u, 0.02, final=1.0)
    assert found.overshoot == pytest.approx(np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)), abs=1e-4)
    assert found.recovery is not None and abs(y[np.searchsorted(t, found.recovery)] - 1) <= 0.02
    assert np.abs(y[np.searchsorted(t, found.recovery - 0.01)] - 1) > 0.0195
    assert found.peak == 0.5 and found.energy == pytest.approx(0.25 * 40.0, rel=1e-4)
    assert response_measures(t[:1000], y[:1000], u[:1000], 0.02, final=1.0).recovery is None


def test_an_unstable_loop_is_reported_and_ends_early() -> None:
    wrong = Plant(CONTROLLER.A, CONTROLLER.B, -40 * CONTROLLER.C)
    loop = sampled_loop(PLANT, sampled_controller(wrong, DT), range(3), W=W, V=V)
    assert not loop.stable
    run = simulate_trial(loop, 60_000, seed=1)
    assert run.diverged and len(run.t) < 60_000 and np.isfinite(run.w).all()
    with pytest.raises(EngineError):
        next(simulate_trials(loop, 4, 2.0, 1))
    caught = simulate_trial(sampled_loop(PLANT, sampled_controller(wrong, DT), range(3), W=W, V=V,
                                         hardware=Hardware(limit=0.1)),
                       3000, seed=1)
    assert not caught.diverged and np.abs(caught.applied).max() <= 0.1


@pytest.mark.parametrize("hardware", [IDEAL, Hardware(limit=1.0), Hardware(step=1e-3), Hardware(limit=1.0, step=1e-3)])
def test_a_run_that_leaves_the_floats_within_a_block_ends_without_a_warning(hardware: Hardware) -> None:
    racing = Plant([[300.0]], [[1.0]], [[1.0]])
    loop = sampled_loop(racing, sampled_controller(Plant([[-1.0]], [[1.0]], [[1e3]]), 0.01), range(1), hardware=hardware)
    run = simulate_trial(loop, 5000, start=np.eye(loop.n)[0])
    assert run.diverged and len(run.t) < 50 and np.isfinite(run.w).all()


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(EngineError):
        Hardware(limit=0.0)
    with pytest.raises(EngineError):
        Hardware(order=3)
    with pytest.raises(EngineError):
        Hardware(delay=-1e-3)
    with pytest.raises(EngineError):
        sampled_controller(sampled_controller(CONTROLLER, DT).last, 2 * DT)
    with pytest.raises(ShapeError):
        sampled_loop(PLANT, sampled_controller(CONTROLLER, DT), range(2))
    with pytest.raises(ShapeError):
        simulate_trial(loop_of(), 100, disturbance=np.zeros((100, 3)))


def test_a_controlled_input_counted_from_the_end_is_not_ground_as_well() -> None:
    """Input −1 was driven by the controller and shaken by the ground at once."""
    controller = sampled_controller(CONTROLLER, DT)
    for controls in ((0, 1, -1), (0, 1, 9), (0, 1, 1)):
        with pytest.raises(ShapeError, match="different numbers from 0 to 4"):
            sampled_loop(PLANT, controller, controls, W=W)


def test_a_sampled_shaping_filter_is_not_taken_for_a_continuous_one() -> None:
    shaping = Plant(0.5 * np.eye(2), np.eye(2), np.eye(2), dt=DT)
    with pytest.raises(EngineError, match="must be continuous"):
        sampled_loop(PLANT, sampled_controller(CONTROLLER, DT), range(3), W=W, shaping=shaping)


def test_starts_kicks_and_rows_must_fit_and_be_finite() -> None:
    controller, loop = sampled_controller(CONTROLLER, DT), loop_of()
    with pytest.raises(ShapeError, match="outputs must have 10 columns"):
        sampled_loop(PLANT, controller, range(3), outputs=np.ones((1, 3)))
    with pytest.raises(ShapeError, match="must enter 10 states"):
        sampled_loop(PLANT, controller, range(3), disturbances=np.ones(10))
    with pytest.raises(ShapeError, match="must have 10 entries"):  # one number was added to every state
        simulate_trial(loop, 9, kicks=((0, [1.0]),))
    with pytest.raises(EngineError, match="holds NaN"):  # gave an empty run
        simulate_trial(loop, 9, start=np.full(loop.n, np.nan))
    with pytest.raises(EngineError, match="holds NaN"):
        simulate_trial(loop, 9, disturbance=np.full((9, loop.Gamma.shape[1]), np.nan))
    for t, y, u in ((np.zeros(0), np.zeros(0), np.zeros((0, 1))), (np.arange(3.0), np.array([1, np.nan, 0]), np.zeros((3, 1))),
                    (np.arange(3.0), np.zeros(3), np.zeros(3))):
        with pytest.raises(EngineError, match=r"at least one sample|NaN or infinity"):
            response_measures(t, y, u, 0.1)


def test_a_controller_pole_that_tustin_cannot_map_is_named() -> None:
    with pytest.raises(EngineError, match="2/dt = 40 rad/s"):
        sampled_controller(Plant([[40.0]], [[1.0]], [[1.0]]), 0.05)
    kf = KalmanFilter([[0.9]], [[1.0]], [[1.0]], 1.0, 1.0, dt=0.1)
    with pytest.raises(EngineError, match="from 1 to"):
        recursive_controller(kf, [[0.1]], Belief([0.0], [[1.0]]), 0)
