"""Many runs of the sampled loop, and densities, against prediction, transfer functions and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from sampled_platform import DT, IDEAL, PLANT, V, W, finished, loop_of
from scipy import signal

from observer_lab.engine import EngineError, Plant, frequency_response, sampled_loop
from observer_lab.engine.sampled import (
    Hardware,
    coil_driver,
    loop_density,
    mechanics_response,
    sampled_controller,
    simulate_trials,
    thin_root,
    welch_expectation,
)
from observer_lab.engine.sampled.monte_carlo import _one


def test_a_batch_is_the_plain_loop_with_its_own_draws() -> None:
    hardware = Hardware(limit=0.005, step=2e-6, bandwidth=70.0)
    loop = loop_of(hardware)
    result, _ = finished(loop, 2, 0.5, 11, 256)
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
    loop, runs = loop_of(), 60
    result, fractions = finished(loop, runs, 8.0, 2, 2048)
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
    loop = loop_of()
    expected = welch_expectation(loop, 16384)
    area = expected.density.sum(axis=0) * expected.frequency[1]
    signals, through = np.vstack([loop.outputs, loop.feedback]), np.vstack([np.zeros((4, 4)), loop.T[-1]])
    promised = np.diag(signals @ loop.covariance @ signals.T + through @ loop.reading @ through.T)
    assert np.allclose(area, promised, rtol=1e-3)


@pytest.mark.slow
def test_the_density_at_a_fine_resolution_is_the_transfer_functions() -> None:
    """Away from the sharp peaks of the open loop, a long window and the transfer function agree."""
    loop = loop_of(Hardware(bandwidth=100.0, delay=1.4e-3, step=1e-6))
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


@pytest.mark.parametrize("hardware", [
    IDEAL, Hardware(bandwidth=100.0, order=2, delay=1.4e-3, step=1e-6), Hardware(delay=3e-3, walk=1e-7),
    Hardware(bandwidth=50.0, delay=0.3e-3),
], ids=["ideal", "driver and delay", "whole delay and walk", "part of a sample"])
def test_the_two_halves_give_the_density_of_the_whole_loop(hardware: Hardware) -> None:
    """Plant and controller apart, closed at each frequency, against the transfer function of all states together."""
    loop, f = loop_of(hardware), np.geomspace(0.1, 490, 80)
    apart = loop_density(loop, mechanics_response(loop, f))
    assert np.abs(apart / loop.noisy.psd(f, np.eye(7)) - 1).max() < 1e-6


def test_without_a_controller_the_density_is_the_plants() -> None:
    silent = sampled_controller(Plant(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((3, 0)), np.zeros((3, 4)), DT), DT)
    loop, f = sampled_loop(PLANT, silent, range(3), W=W, V=V), np.geomspace(0.1, 20, 50)
    open_loop = np.abs(frequency_response(PLANT.A, PLANT.B[:, 3:], PLANT.C, np.zeros((4, 2)), 2 * np.pi * f)) ** 2
    assert np.allclose(loop_density(loop, mechanics_response(loop, f))[:, :4], 2e-12 * open_loop.sum(axis=2), rtol=1e-3)


def test_a_very_fine_converter_is_not_taken_for_a_run_away() -> None:
    """Readings are carried in steps of the converter; beside a step of 1e-22 they all looked infinite."""
    fine, _ = finished(loop_of(Hardware(step=1e-22)), 3, 0.5, 7, 256)
    ideal, _ = finished(loop_of(Hardware(limit=1e9)), 3, 0.5, 7, 256)
    assert not fine.diverged.any()
    assert np.allclose(fine.rms, ideal.rms, rtol=1e-6)


def test_lengths_without_sense_are_refused() -> None:
    for seconds, together in ((np.nan, 5), (np.inf, 5), (1.0, 0)):
        with pytest.raises(EngineError, match=r"at least one run|finite number|from 1|above 0|at most"):
            next(simulate_trials(loop_of(), 3, seconds, 0, together=together))
    with pytest.raises(EngineError, match="from 2 to"):
        welch_expectation(loop_of(), 1)
