"""What is refused, and the range that the sentence names."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from observer_lab.engine import EngineError, Plant, balanced_truncation, c2d, gramians, sensitivity, ss, tf

PLANT = Plant([[-1, 0.2], [0, -2]], [[1], [1]], [[1, 1]])


@pytest.mark.parametrize("call", [
    lambda: tf([], [1, 2]), lambda: tf([1], [1, 2], True), lambda: ss([[-1]], [[1]], [[1]], 0, True), lambda: c2d(PLANT, True),
    lambda: Plant([[-1]], [[1]], [[1]], dt=True)])
def test_no_number_is_guessed(call: Callable[[], object]) -> None:
    with pytest.raises(EngineError):
        call()


@pytest.mark.parametrize("order", [-1, 3, 7, 1000])
def test_a_refused_order_names_its_range(order: int) -> None:
    with pytest.raises(EngineError, match="from 0 to 2"):
        balanced_truncation(PLANT, order)


def test_half_an_order_names_no_false_range() -> None:
    with pytest.raises(EngineError, match=r"^order must be a whole number; it is 1\.5\.$"):
        balanced_truncation(PLANT, 1.5)


def test_numbers_of_python_with_an_imaginary_part_of_zero() -> None:
    entries = np.array([[-1 + 0j, 0], [2, -3 + 0j]], dtype=object)
    assert np.array_equal(Plant(entries, [[1], [0j]], [[1, 0]]).A, [[-1, 0], [2, -3]])
    with pytest.raises(EngineError, match="imaginary"):
        Plant(np.array([[-1 + 1j]], dtype=object), [[1]], [[1]])


def test_a_loop_without_states_has_a_sensitivity() -> None:
    still = Plant(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), [[1.0]])
    assert np.allclose(sensitivity(still, [[-2.0]]).at(np.array([0.0, 1.0]))[:, 0, 0], 1 / 3)


@pytest.mark.parametrize("rates", [(1e-3, 1.0, 1e9), (1e9, 1.0, 1e-3), (1.0, 1e-4, 1e5), (1e-5, 1e4, 1.0)])
def test_a_cascade_over_nine_decades(rates: tuple[float, float, float]) -> None:
    """Its Gramian entry by entry against fractions: p_ij (a_i + a_j) = p_(i−1)j + p_i(j−1), p_11 = 1/(2 a_1)."""
    a = rates
    A = -np.diag(a) + np.eye(3, k=-1)
    P = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            known = (P[i - 1, j] if i else 0.0) + (P[i, j - 1] if j else 0.0) + (1.0 if i == j == 0 else 0.0)
            P[i, j] = known / (a[i] + a[j])
    found = gramians(Plant(A, [[1], [0], [0]], [[0, 0, 1]])).controllability
    np.testing.assert_allclose(found, P, rtol=1e-9)
