"""The sampled loop against oracles: exact propagation in 40 digits, a plain loop, Lyapunov, scipy."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from scipy import signal
from scipy.linalg import solve_continuous_lyapunov

from app.engine import (
    Belief,
    EngineError,
    Hardware,
    KalmanFilter,
    MonteCarlo,
    Plant,
    SampledLoop,
    ShapeError,
    balanced_truncation,
    coil_driver,
    compensator,
    frequency_response,
    loop_density,
    lqe,
    lqr,
    mechanics_response,
    monte_carlo,
    recursive_controller,
    response_measures,
    run_trial,
    sampled_controller,
    sampled_loop,
    welch_expectation,
)
from app.engine.monte_carlo import _one
from app.engine.noise import step_covariance
from app.engine.sampled_loop import thin_root
from app.plants import platform

DT = 1e-3
PLANT = platform.plant()
W, V = 1e-12 * np.eye(2), 1e-10 * np.eye(4)
IDEAL = Hardware()
KICK = np.array([0, 0, 0, 0, 0, 0.015, -0.02, 0.09, -0.02, -0.02])


def _reduced() -> tuple[Plant, np.ndarray, np.ndarray, np.ndarray]:
    """Eight states with the coils as inputs, G, K and L."""
    cut = balanced_truncation(PLANT, 8).plant
    believed = Plant(cut.A, cut.B[:, :3], cut.C)
    weight = np.diag([1e5, 1e7, 1e5, 1e7])
    return (believed, cut.B[:, 3:], lqr(cut.A, cut.B[:, :3], cut.C.T @ weight @ cut.C, np.eye(3)).gain,
            lqe(cut.A, cut.B[:, 3:], cut.C, W, V).gain)


BELIEVED, GROUND, K, L = _reduced()
CONTROLLER = compensator(BELIEVED, K, L)


def _loop(hardware: Hardware = IDEAL) -> SampledLoop:
    return sampled_loop(PLANT, sampled_controller(CONTROLLER, DT), range(3), hardware=hardware, W=W, V=V)


def _finished(loop: SampledLoop, runs: int, seconds: float, seed: int, segment: int) -> tuple[MonteCarlo, list[float]]:
    yielded = list(monte_carlo(loop, runs, seconds, seed, segment))
    result = yielded[-1][1]
    assert result is not None
    return result, [fraction for fraction, _ in yielded]


def _exact(A: np.ndarray, B: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """e^{A t} and ∫e^{As}ds B in 40 digits."""
    with mpmath.workdps(40):
        n, m = B.shape
        block = mpmath.zeros(n + m)
        for i in range(n):
            for j in range(n):
                block[i, j] = mpmath.mpf(float(A[i, j])) * mpmath.mpf(duration)
            for j in range(m):
                block[i, n + j] = mpmath.mpf(float(B[i, j])) * mpmath.mpf(duration)
        power = mpmath.expm(block, method="taylor")
        both = np.array([[float(power[i, j]) for j in range(n + m)] for i in range(n)])
    return both[:, :n], both[:, n:]


def _scipys(method: str) -> tuple[np.ndarray, ...]:
    peer: Any = signal.cont2discrete((CONTROLLER.A, CONTROLLER.B, CONTROLLER.C, CONTROLLER.D), DT, method)
    return peer[:4]


def _plain(hardware: Hardware, steps: int, seed: int | None, ground: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States, readings and applied commands by the definition: one sample after another, commands in a queue."""
    driver, dt = coil_driver(hardware, 3), DT
    first = 0 if driver is None else driver.n
    n, N = PLANT.n, PLANT.n + first
    A, B = np.zeros((N, N)), np.zeros((N, 5))
    A[first:, first:], B[first:, 3:] = PLANT.A, PLANT.B[:, 3:]
    if driver is None:
        B[:, :3] = PLANT.B[:, :3]
    else:
        A[:first, :first], A[first:, :first], B[:first, :3] = driver.A, PLANT.B[:, :3] @ driver.C, driver.B
    whole = int(hardware.delay / dt + 1e-9)
    part = hardware.delay - whole * dt
    early, late = _exact(A, B, part), _exact(A, B, dt - part)
    Ac, Bc, Cc, Dc = _scipys("bilinear")
    loop = _loop(hardware)
    jumps, v = np.zeros((steps, loop.n)), np.zeros((steps, 4))
    if seed is not None:
        for_ground, for_v, for_bias = np.random.default_rng(seed).spawn(3)
        draws = [for_ground.standard_normal((steps, 8))]
        if hardware.walk:
            draws.append(for_bias.standard_normal((steps, 4)))
        jumps = np.hstack(draws) @ loop.jump.T
        v = for_v.standard_normal((steps, 4)) @ loop.sensor.T
    z, c, bias, queue = np.zeros(N), np.zeros(CONTROLLER.n), np.zeros(4), [np.zeros(3)] * (whole + 1)
    states, readings, commands = np.empty((steps, n)), np.empty((steps, 4)), np.empty((steps, 3))
    for k in range(steps):
        m = PLANT.C @ z[first:] + bias + v[k]
        if hardware.step:
            m = hardware.step * np.round(m / hardware.step)
        u = np.clip(Cc @ c + Dc @ m, -hardware.limit, hardware.limit)
        c = Ac @ c + Bc @ m
        states[k], readings[k], commands[k] = z[first:], m, u
        queue.append(u)
        older, newer = queue[-2 - whole], queue[-1 - whole]
        z = early[0] @ z + early[1] @ np.concatenate([older, ground[k]])
        z = late[0] @ z + late[1] @ np.concatenate([newer, ground[k]])
        z += jumps[k, :N]
        bias = bias + hardware.ramp * dt + (jumps[k, loop.bias] if hardware.walk else 0.0)
        if k == 99:
            z[first:] += KICK
    return states, readings, commands


@pytest.mark.parametrize("hardware", [
    Hardware(), Hardware(bandwidth=80.0), Hardware(bandwidth=60.0, order=2), Hardware(delay=2e-3), Hardware(delay=0.4e-3),
    Hardware(delay=2.3e-3, bandwidth=90.0, order=2, ramp=1e-6, walk=1e-7),
], ids=["ideal", "lag", "lag of second order", "whole delay", "part of a sample", "together"])
def test_a_linear_run_is_exact(hardware: Hardware) -> None:
    steps = 3000
    ground = np.zeros((steps, 2))
    ground[500:] = 1e-5, -2e-5
    run = run_trial(_loop(hardware), steps, 7, disturbance=ground, kicks=((100, KICK),))
    states, readings, commands = _plain(hardware, steps, 7, ground)
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
    run = run_trial(_loop(hardware), steps, 3, disturbance=ground, kicks=((100, KICK),))
    states, _, commands = _plain(hardware, steps, 3, ground)
    assert np.abs(run.x - states).max() <= 1e-9 * np.abs(states).max()
    assert np.abs(run.applied - commands).max() <= 1e-9 * np.abs(commands).max()
    if np.isfinite(hardware.limit):
        assert np.abs(run.asked).max() > hardware.limit
        assert np.abs(run.applied).max() == hardware.limit


def test_designs_with_one_plant_feel_one_noise() -> None:
    silent = sampled_controller(Plant(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((3, 0)), np.zeros((3, 4)), DT), DT)
    calm, rough = (run_trial(sampled_loop(PLANT, silent, range(3), W=W, V=V, hardware=hardware), 500, 9)
                   for hardware in (IDEAL, Hardware(walk=1e-6, bandwidth=50.0, delay=2e-3)))
    assert np.abs(calm.x - rough.x).max() <= 1e-9 * np.abs(calm.x).max()
    other = sampled_loop(PLANT, sampled_controller(CONTROLLER, DT, "hold"), range(3), W=W, V=V,
                         hardware=Hardware(bandwidth=100.0))
    assert other.jump[3:13].shape == _loop().jump[:10].shape
    assert np.allclose(other.jump[3:13], _loop().jump[:10], rtol=1e-9, atol=0)


def test_the_ground_pushes_with_its_exact_covariance() -> None:
    loop, G = _loop(), PLANT.B[:, 3:]
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
        ours = sampled_controller(CONTROLLER, DT, method).last  # type: ignore[arg-type]
        peer = _scipys(name)
        for frequency in (0.1, 1.0, 20.0, 300.0):
            z = np.exp(2j * np.pi * frequency * DT)
            one = ours.C @ np.linalg.solve(z * np.eye(ours.n) - ours.A, ours.B) + ours.D
            two = peer[2] @ np.linalg.solve(z * np.eye(ours.n) - peer[0], peer[1]) + peer[3]
            assert np.abs(one - two).max() <= 1e-9 * np.abs(two).max()


@pytest.mark.parametrize("told", ["commanded", "applied"])
def test_the_recursive_controller_is_the_kalman_filter_with_feedback(told: str) -> None:
    """Its commands are −K x̂[k|k] of a filter run over the same readings and the inputs it was told."""
    kf = KalmanFilter.from_plant(BELIEVED, W, V, DT, GROUND)
    start = Belief(np.zeros(8), 1e-9 * np.eye(8))
    controller = recursive_controller(kf, 0.2 * K, start, 400, told)  # type: ignore[arg-type]
    loop = sampled_loop(PLANT, controller, range(3), W=W, V=V, hardware=Hardware(limit=0.02))
    run = run_trial(loop, 400, 5, kicks=((50, 0.1 * KICK),))
    assert np.any(run.asked != run.applied)
    track = kf.run(start, run.read, run.applied if told == "applied" else run.asked)
    assert np.abs(run.asked + track.means @ (0.2 * K).T).max() <= 1e-9 * np.abs(run.asked).max()


def test_a_batch_is_the_plain_loop_with_its_own_draws() -> None:
    hardware = Hardware(limit=0.005, step=2e-6, bandwidth=70.0)
    loop = _loop(hardware)
    result, _ = _finished(loop, 2, 0.5, 11, 256)
    assert result.clipped.max() > 0
    rng, start = np.random.default_rng(11).spawn(1)[0], thin_root(loop.covariance)
    w = rng.standard_normal((2, start.shape[1])) @ start.T
    v = rng.standard_normal((2, 4)) @ loop.sensor.T
    squares, over, r = np.zeros((2, 7)), np.zeros(2), loop.jump.shape[1]
    normals = [rng.standard_normal((size * 2, r + 4)).reshape(size, 2, r + 4) for size in (200, 200, 100)]
    for draw in np.concatenate(normals):
        m = hardware.step * np.round((w @ loop.Y.T + v) / hardware.step)
        u = w @ loop.U[0].T + m @ loop.T[0].T
        over += (np.abs(u) > hardware.limit).any(axis=1)
        u = np.clip(u, -hardware.limit, hardware.limit)
        squares += np.hstack([w @ loop.outputs.T, u]) ** 2
        w = w @ loop.F[0].T + m @ loop.F_m[0].T + u @ loop.F_s[0].T + draw[:, :r] @ loop.jump.T
        v = draw[:, r:] @ loop.sensor.T
    assert np.allclose(result.rms, np.sqrt(squares / 500), rtol=1e-7)
    assert np.array_equal(result.clipped, over / 500)


def test_monte_carlo_meets_its_prediction() -> None:
    """Mean Welch density within 5 standard errors of its expectation at (nearly) every frequency; variances by Lyapunov."""
    loop, runs = _loop(), 60
    result, fractions = _finished(loop, runs, 8.0, 2, 2048)
    assert fractions == sorted(fractions) and fractions[-1] == 1.0
    expected = welch_expectation(loop, 2048)
    assert np.array_equal(expected.frequency, result.frequency)
    away = np.abs(result.density - expected.density)[2:] / (result.spread[2:] / np.sqrt(runs))
    assert np.mean(away < 2.0) > 0.9 and away.max() < 7.0
    signals = np.vstack([loop.outputs, loop.feedback])
    through = np.vstack([np.zeros((4, 4)), loop.T[-1]])
    promised = np.sqrt(np.diag(signals @ loop.covariance @ signals.T + through @ loop.reading @ through.T))
    assert np.allclose(np.sqrt(np.mean(result.rms**2, axis=0)), promised, rtol=0.05)


def test_the_expectation_is_calibrated() -> None:
    """Its area is the variance, and where the spectrum is flat for a segment it is the density itself."""
    loop = _loop()
    expected = welch_expectation(loop, 16384)
    area = expected.density.sum(axis=0) * expected.frequency[1]
    signals, through = np.vstack([loop.outputs, loop.feedback]), np.vstack([np.zeros((4, 4)), loop.T[-1]])
    promised = np.diag(signals @ loop.covariance @ signals.T + through @ loop.reading @ through.T)
    assert np.allclose(area, promised, rtol=1e-3)


def test_the_density_at_a_fine_resolution_is_the_transfer_functions() -> None:
    """Away from the sharp peaks of the open loop, a long window and the transfer function agree."""
    loop = _loop(Hardware(bandwidth=100.0, delay=1.4e-3, step=1e-6))
    expected = welch_expectation(loop, 65536)
    keep = (expected.frequency > 0.3) & (expected.frequency < 400)
    f = expected.frequency[keep]
    promised = loop.noisy.psd(f, np.eye(7))
    gap = np.abs(expected.density[keep] / promised - 1)
    assert gap.max() < 0.05 and gap[(f > 3) & (np.abs(f - 30.2) > 3)].max() < 0.01
    assert np.allclose(loop.noisy.variance(np.eye(7))[:4], np.diag(loop.outputs @ loop.covariance @ loop.outputs.T), rtol=1e-6)


def test_welch_of_a_batch_is_scipys() -> None:
    series = np.random.default_rng(4).standard_normal((3, 5000))
    density, rms, peak = _one(series, DT, 1024)
    assert np.allclose(density.T, signal.welch(series, 1 / DT, nperseg=1024)[1], rtol=1e-10)
    assert np.allclose(rms, np.sqrt(np.mean(series**2, axis=1))) and np.allclose(peak, np.abs(series).max(axis=1))


@pytest.mark.parametrize("order", [1, 2])
def test_a_driver_is_three_decibels_down_at_its_bandwidth(order: int) -> None:
    driver = coil_driver(Hardware(bandwidth=40.0, order=order), 2)
    assert driver is not None
    H = driver.C @ np.linalg.solve(2j * np.pi * 40.0 * np.eye(driver.n) - driver.A, driver.B)
    assert np.allclose(np.abs(H), np.eye(2) / np.sqrt(2), atol=1e-12)
    assert np.allclose(driver.C @ np.linalg.solve(-driver.A, driver.B), np.eye(2))


def test_measures_of_a_step_are_the_textbooks() -> None:
    zeta, t = 0.3, np.arange(0.0, 40.0, 1e-3)
    _, y = signal.step((1.0, (1.0, 2 * zeta, 1.0)), T=t)
    u = np.column_stack([np.full(len(t), 0.5), np.zeros(len(t))])
    found = response_measures(t, y, u, 0.02, 1.0)
    assert found.overshoot == pytest.approx(np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)), abs=1e-4)
    assert found.recovery is not None and abs(y[np.searchsorted(t, found.recovery)] - 1) <= 0.02
    assert np.abs(y[np.searchsorted(t, found.recovery - 0.01)] - 1) > 0.0195
    assert found.peak == 0.5 and found.energy == pytest.approx(0.25 * 40.0, rel=1e-4)
    assert response_measures(t[:1000], y[:1000], u[:1000], 0.02, 1.0).recovery is None


def test_an_unstable_loop_is_reported_and_ends_early() -> None:
    wrong = Plant(CONTROLLER.A, CONTROLLER.B, -40 * CONTROLLER.C)
    loop = sampled_loop(PLANT, sampled_controller(wrong, DT), range(3), W=W, V=V)
    assert not loop.stable
    run = run_trial(loop, 60_000, 1)
    assert run.diverged and len(run.t) < 60_000 and np.isfinite(run.w).all()
    with pytest.raises(EngineError):
        next(monte_carlo(loop, 4, 2.0, 1))
    caught = run_trial(sampled_loop(PLANT, sampled_controller(wrong, DT), range(3), W=W, V=V, hardware=Hardware(limit=0.1)),
                       3000, 1)
    assert not caught.diverged and np.abs(caught.applied).max() <= 0.1


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
        run_trial(_loop(), 100, disturbance=np.zeros((100, 3)))


@pytest.mark.parametrize("hardware", [
    IDEAL, Hardware(bandwidth=100.0, order=2, delay=1.4e-3, step=1e-6), Hardware(delay=3e-3, walk=1e-7),
    Hardware(bandwidth=50.0, delay=0.3e-3),
], ids=["ideal", "driver and delay", "whole delay and walk", "part of a sample"])
def test_the_two_halves_give_the_density_of_the_whole_loop(hardware: Hardware) -> None:
    """Plant and controller apart, closed at each frequency, against the transfer function of all states together."""
    loop, f = _loop(hardware), np.geomspace(0.1, 490, 80)
    apart = loop_density(loop, mechanics_response(loop, f))
    assert np.abs(apart / loop.noisy.psd(f, np.eye(7)) - 1).max() < 1e-6


def test_without_a_controller_the_density_is_the_plants() -> None:
    silent = sampled_controller(Plant(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((3, 0)), np.zeros((3, 4)), DT), DT)
    loop, f = sampled_loop(PLANT, silent, range(3), W=W, V=V), np.geomspace(0.1, 20, 50)
    open_loop = np.abs(frequency_response(PLANT.A, PLANT.B[:, 3:], PLANT.C, np.zeros((4, 2)), 2 * np.pi * f)) ** 2
    assert np.allclose(loop_density(loop, mechanics_response(loop, f))[:, :4], 2e-12 * open_loop.sum(axis=2), rtol=1e-3)
