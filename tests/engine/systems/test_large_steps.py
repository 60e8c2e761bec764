"""Steps of many states: the exponential in any units, the held input, copies that do not act on each other."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp
from scipy.linalg import block_diag, expm

from observer_lab.engine import EngineError, Plant, c2d
from observer_lab.engine.systems import affine_scan, step_matrices


def rates(n: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) / np.sqrt(n)
    return A - (np.linalg.eigvals(A).real.max() + 0.2) * np.eye(n)


@pytest.mark.parametrize("duration", [1e-3, 0.3, 40.0])
@pytest.mark.parametrize("decades", [0, 9])
def test_a_step_of_sixty_states_is_the_exponential_in_any_units(duration: float, decades: int) -> None:
    A = rates(60, 0)
    units = 10.0 ** np.random.default_rng(1).uniform(-decades, decades, 60)
    Phi, Phi1 = step_matrices(A * units[:, None] / units, duration)
    true = expm(A * duration)
    size = max(1.0, duration)
    np.testing.assert_allclose(Phi / units[:, None] * units, true, atol=1e-12)
    np.testing.assert_allclose(A @ (Phi1 / units[:, None] * units), true - np.eye(60), atol=1e-11 * size)


def test_a_held_input_of_fifty_states_in_fifty_digits() -> None:
    A, B = rates(50, 2), np.random.default_rng(3).standard_normal((50, 2))
    with mp.workdps(50):
        wide = mp.zeros(52)
        wide[:50, :50], wide[:50, 50:] = mp.matrix(A.tolist()), mp.matrix(B.tolist())
        h = mp.mpf(1) / 8
        power, term = mp.eye(52), mp.eye(52)
        for k in range(1, 40):
            term = term * wide * (h / k)
            power = power + term
        Phi, Gamma = (np.array(part.tolist(), dtype=float) for part in (power[:50, :50], power[:50, 50:]))
    found = c2d(Plant(A, B, np.eye(1, 50)), 0.125)
    np.testing.assert_allclose(found.A, Phi, atol=2e-15)
    np.testing.assert_allclose(found.B, Gamma, atol=2e-15)


@pytest.mark.parametrize("steps", [1, 63, 64, 65, 300])
def test_a_plant_and_its_copy_step_as_one(steps: int) -> None:
    A = rates(30, 4)
    M, z0 = block_diag(A, A), np.random.default_rng(5).standard_normal(60)
    Phi, Phi1 = step_matrices(M, 0.1)
    np.testing.assert_allclose(Phi, expm(0.1 * M), atol=1e-13)
    np.testing.assert_allclose(M @ Phi1, Phi - np.eye(60), atol=1e-13)
    z, states = z0, affine_scan(Phi, None, z0, steps)
    for k in range(steps):
        z = Phi @ z
        np.testing.assert_allclose(states[k + 1], z, atol=1e-12)


def test_a_step_that_overflows_is_one_sentence() -> None:
    with pytest.raises(EngineError, match="too large"):
        step_matrices(1e4 * np.eye(60), 1.0)


def test_a_plant_and_a_copy_of_it_step_as_each_does_alone() -> None:
    rng = np.random.default_rng(3)
    for n, steps in ((30, 1), (30, 200), (60, 63), (60, 500)):
        Phi = rng.standard_normal((n, n)) / (2 * np.sqrt(n))
        starts = rng.standard_normal((2, n))
        both = affine_scan(np.kron(np.eye(2), Phi), None, starts.ravel(), steps)
        alone = np.hstack([affine_scan(Phi, None, start, steps) for start in starts])
        np.testing.assert_allclose(both, alone, rtol=0, atol=1e-13 * np.abs(alone).max())
