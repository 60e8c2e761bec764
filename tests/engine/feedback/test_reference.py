"""Gains for a command: the steady output by python-control, the poles of the augmented loop by numpy."""

from __future__ import annotations

import control
import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.signal import place_poles

from observer_lab.engine import EngineError, Plant
from observer_lab.engine.feedback import integral_action, reference_gain


def loop(seed: int, dt: float) -> tuple[Plant, np.ndarray, np.ndarray]:
    """A random plant with as many commanded outputs as inputs or fewer, its feedback and the poles of it."""
    rng = np.random.default_rng(seed)
    n, m = 4, 2
    p = 1 + seed % 2
    A, B = rng.standard_normal((n, n)), rng.standard_normal((n, m))
    poles = np.array([0.1, 0.3, 0.5, 0.7]) if dt else -np.array([1.0, 2.0, 3.0, 4.0])
    D = rng.standard_normal((p, m)) * (seed % 3)
    return Plant(A, B, rng.standard_normal((p, n)), D, dt), place_poles(A, B, poles).gain_matrix, poles


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("dt", [0.0, 0.1])
def test_the_steady_gain_from_the_command_is_one(seed: int, dt: float) -> None:
    plant, K, _ = loop(seed, dt)
    N = reference_gain(plant, K)
    closed = control.ss(plant.A - plant.B @ K, plant.B @ N, plant.C - plant.D @ K, plant.D @ N, dt)
    np.testing.assert_allclose(np.atleast_2d(closed.dcgain()), np.eye(plant.p), atol=1e-8)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("dt", [0.0, 0.1])
@pytest.mark.parametrize("own", [False, True])
def test_integral_action_keeps_the_poles_and_adds_its_own(seed: int, dt: float, own: bool) -> None:
    plant, K, poles = loop(seed, dt)
    rate, p = 0.6, plant.p
    steady = control.ss(plant.A - plant.B @ K, plant.B, plant.C - plant.D @ K, plant.D, dt).dcgain().reshape(p, plant.m)
    N = reference_gain(plant, K) + null_space(steady) @ np.full((plant.m - p, p), 0.7)
    found = integral_action(plant, K, rate, N=N if own else None)
    hold = np.eye(p) if dt else np.zeros((p, p))
    A = np.block([[plant.A, np.zeros((plant.n, p))], [-plant.C, hold]])
    B = np.vstack([plant.B, -plant.D])
    mine = np.linalg.eigvals(A - B @ np.hstack([found.K, -found.K_I]))
    wanted = np.concatenate([poles, np.full(p, 1 - rate if dt else -rate)])
    np.testing.assert_allclose(np.poly(mine), np.poly(wanted), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("C", [[[0.0, 1.0]], [[1.0, 0.0], [0.0, 1.0]]])
def test_what_no_constant_input_holds_is_refused(C: list[list[float]]) -> None:
    """The velocity of a mass rests at nothing but zero, and one force cannot hold two outputs."""
    with pytest.raises(EngineError, match="No constant input"):
        reference_gain(Plant([[0, 1], [0, 0]], [[0], [1]], C), [[1.0, 1.0]])


def test_a_pole_at_zero_is_refused() -> None:
    with pytest.raises(EngineError, match="holds a constant"):
        integral_action(Plant([[0.0]], [[1.0]], [[1.0]]), [[0.0]], 1.0)


def test_a_gain_that_does_not_hold_the_outputs_is_refused() -> None:
    with pytest.raises(EngineError, match="N does not hold the outputs"):
        integral_action(Plant([[-1.0]], [[1.0]], [[1.0]]), [[1.0]], 1.0, N=[[1.0]])


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_the_gain_of_a_command_holds_in_any_unit_of_an_input(unit: float) -> None:
    plant = Plant(np.diag([-1.0, -2.0]), np.array([[1.0, 0.3], [0.2, 1.0]]), np.eye(2))
    units = np.array([unit, 1.0])
    found = reference_gain(Plant(plant.A, plant.B * units, plant.C), np.zeros((2, 2)))
    np.testing.assert_allclose(found * units[:, None], reference_gain(plant, np.zeros((2, 2))), rtol=1e-9)
