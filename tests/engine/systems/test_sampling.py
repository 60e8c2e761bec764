"""Undoing the hold: the continuous plant whose samples are the sampled plant, or one sentence why there is none."""

from __future__ import annotations

import numpy as np
import pytest
from control import StateSpace, c2d
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.engine import EngineError, Plant
from observer_lab.engine.systems import continuous_of


@settings(max_examples=60, derandomize=True, database=None)
@given(st.integers(0, 10_000), st.integers(1, 12), st.floats(0.001, 0.4))
def test_the_zero_order_hold_of_python_control_is_undone(seed: int, n: int, dt: float) -> None:
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) / np.sqrt(n)  # |Im λ| stays below π/dt
    plant = Plant(A, rng.standard_normal((n, 2)), rng.standard_normal((1, n)), rng.standard_normal((1, 2)))
    held = c2d(StateSpace(plant.A, plant.B, plant.C, plant.D), dt)
    back = continuous_of(Plant(held.A, held.B, held.C, held.D, dt))
    assert back.dt == 0
    for ours, given_ in ((back.A, plant.A), (back.B, plant.B), (back.C, plant.C), (back.D, plant.D)):
        assert np.abs(ours - given_).max() < 1e-7 * max(1.0, np.abs(given_).max()) / dt


def test_a_double_integrator_comes_back_exactly() -> None:
    back = continuous_of(Plant(np.array([[1, 0.1], [0, 1]]), np.array([[0.005], [0.1]]), np.array([[1, 0]]), None, 0.1))
    assert np.abs(back.A - [[0, 1], [0, 0]]).max() < 1e-9
    assert np.abs(back.B - [[0], [1]]).max() < 1e-9


def test_a_continuous_plant_is_returned_as_it_is() -> None:
    plant = Plant(np.eye(2), np.eye(2), np.eye(2))
    assert continuous_of(plant) is plant


@pytest.mark.parametrize("A, word", [
    ([[0.0, 1.0], [0.0, 0.0]], "delay"),
    ([[-0.5]], "-0.5"),
    ([[-0.5, 0.0], [0.0, -0.5]], "negative real axis"),
])
def test_a_sampled_plant_with_nothing_behind_it_is_refused_in_one_sentence(A: list, word: str) -> None:
    n = len(A)
    with pytest.raises(EngineError, match=word) as problem:
        continuous_of(Plant(np.array(A), np.ones((n, 1)), np.ones((1, n)), None, 0.1))
    assert "\n" not in str(problem.value)
