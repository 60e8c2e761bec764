"""Relative accuracy where little is left: roll-off, and roots of polynomials, against fifty digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from observer_lab.engine import frequency_response
from observer_lab.engine.design import polynomial_roots, rational


def lags(rates: list[float]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A chain of lags rates/(s + rates), one driving the next."""
    n = len(rates)
    A = np.diag(-np.array(rates)) + np.diag(np.array(rates[1:]), -1)
    return A, rates[0] * np.eye(n)[:, :1], np.eye(n)[n - 1:], np.zeros((1, 1))


@pytest.mark.parametrize("rates", [[1.0 + 0.3 * k for k in range(8)], [2.0] * 6, [0.1, 1.0, 10.0, 100.0, 3.0, 30.0]])
def test_the_roll_off_of_a_chain_of_lags_has_six_digits(rates: list[float]) -> None:
    omega = np.geomspace(1e-2, 1e4, 40)
    found = frequency_response(*lags(rates), omega)[:, 0, 0]
    with mpmath.workdps(50):
        right = [complex(mpmath.fprod(r / (mpmath.mpc(0, w) + r) for r in rates)) for w in omega]
    assert np.abs(right).min() < 1e-12
    np.testing.assert_allclose(found, right, rtol=1e-6)


def test_the_roll_off_within_a_long_sweep_has_six_digits() -> None:
    rates = [1.0 + 0.3 * k for k in range(8)]
    omega = np.geomspace(1e-2, 1e3, 500)
    right = np.prod([r / (1j * omega + r) for r in rates], axis=0)
    np.testing.assert_allclose(frequency_response(*lags(rates), omega)[:, 0, 0], right, rtol=1e-6)


@pytest.mark.parametrize("seed", range(150))
def test_a_rational_function_with_repeated_roots_keeps_its_response(seed: int) -> None:
    rng = np.random.default_rng(seed)
    single = [-float(rng.uniform(0.2, 5.0)) for _ in range(int(rng.integers(1, 3)))]
    pair = complex(-rng.uniform(0.2, 3.0), rng.uniform(0.2, 5.0))
    poles = single * int(rng.integers(1, 4)) + [pair, pair.conjugate()] * int(rng.integers(0, 3))
    den = np.poly(poles).real
    roots = polynomial_roots(den)
    assert np.array_equal(np.sort_complex(roots), np.sort_complex(roots.conj()))
    plant = rational([1.0], den)
    omega = np.array([0.01, 0.3, 1.0, 4.0])
    found = frequency_response(plant.A, plant.B, plant.C, plant.D, omega)[:, 0, 0]
    np.testing.assert_allclose(found, 1 / np.polyval(den, 1j * omega), rtol=1e-9)
