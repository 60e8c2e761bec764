"""Laws of units: what the engine says of a plant does not depend on the units that the plant is written in."""

from __future__ import annotations

import numpy as np
import pytest
from unit_cases import random_case, random_units
from unit_laws import LAWS, breach

from observer_lab.engine import Plant, controllability, kalman_decomposition, lqe, lqr, observability, place
from observer_lab.engine.systems import balance, transmission_zeros


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("law", LAWS)
def test_a_law_of_units(law: str, seed: int) -> None:
    rng = np.random.default_rng((2, seed))
    case = random_case(rng, sampled=seed % 4 == 3)
    assert not breach(law, case, random_units(case, rng))


@pytest.mark.parametrize("seed", range(20))
def test_balanced_quantities_are_the_same_in_any_units(seed: int) -> None:
    """No entry of A beyond its rate; and A itself the same but for the rounding of scales to powers of two."""
    rng = np.random.default_rng((3, seed))
    case = random_case(rng)
    moved = case.to(random_units(case, rng)).plant
    one, other = (balance(p.A, p.B, p.C) for p in (case.plant, moved))
    for own, plant in ((one, case.plant), (other, moved)):
        assert np.abs(own.A(plant.A)).max() <= 2.1 * own.rate
    ratio = np.abs(other.A(moved.A) / other.rate) / np.maximum(np.abs(one.A(case.plant.A) / one.rate), 1e-300)
    assert np.all((ratio > 0.24) & (ratio < 4.1) | (case.plant.A == 0))


def test_a_variance_of_micrometres_beside_one_of_metres_is_positive_definite() -> None:
    A, C = np.diag([-1.0, -2.0]), np.eye(2)
    found = lqe(A, np.eye(2), C, np.diag([1e-18, 1.0]), np.diag([1e-18, 1.0]))
    same = lqe(A, np.eye(2), C, np.eye(2), np.eye(2))
    np.testing.assert_allclose(found.gain, same.gain, rtol=1e-9)


def test_an_indefinite_weight_beside_a_large_one_is_refused() -> None:
    with pytest.raises(ValueError, match="negative eigenvalue"):
        lqr(np.diag([-1.0, -2.0]), np.eye(2), np.diag([1e12, -1.0]), np.eye(2))


def test_a_cascade_in_unlike_units_is_detectable() -> None:
    A = np.array([[-1.0, 1e9, 0.0], [0.0, 0.5, 1e9], [0.0, 0.0, -3.0]])
    plant = Plant(A, np.array([[0.0], [0.0], [1e-9]]), np.array([[1e-9, 0.0, 0.0]]))
    assert observability(plant).detectable and controllability(plant).controllable
    assert kalman_decomposition(plant).sizes == (3, 0, 0, 0)


def test_no_zero_is_invented_at_infinity() -> None:
    """A chain of six integrators in steps of a hundred: relative degree six, no zeros."""
    d = 100.0 ** np.arange(6)
    A = np.diag(np.ones(5), 1) / d[:, None] * d
    plant = Plant(A, np.eye(6)[:, 5:] / d[5], np.eye(6)[:1] * d[0])
    found = transmission_zeros(plant)
    assert found is not None and len(found) == 0


def test_a_gain_follows_the_units_of_the_states() -> None:
    A, B = np.array([[0.0, 1.0], [-2.0, -0.3]]), np.array([[0.0], [1.0]])
    d = np.array([1e-6, 1e6])
    plain, moved = place(A, B, [-1, -2]), place(A * d / d[:, None], B / d[:, None], [-1, -2])
    np.testing.assert_allclose(moved.gain / d, plain.gain, rtol=1e-12, atol=1e-14)


def test_the_ranks_of_a_functional_observer_do_not_hang_on_units() -> None:
    """Directions were chosen in the units given, so that ranks told of an observer that was found that there was none."""
    rng = np.random.default_rng((1, 12))
    case = random_case(rng)
    assert not breach("functional", case, random_units(case, rng))
