"""Dragging a pole: sets stay closed under conjugation, gains follow without a leap."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pole_requests import random_pair, random_poles

from observer_lab.engine import EngineError, PoleError, place
from observer_lab.engine.systems import check_poles, move_pole


def test_a_pair_moves_together():
    assert move_pole((-1 + 2j, -3, -1 - 2j), 0, -2 + 5j, axis_snap=0.1) == (-2 + 5j, -3, -2 - 5j)
    assert move_pole((-1 + 2j, -3, -1 - 2j), 2, -2 - 5j, axis_snap=0.1) == (-2 + 5j, -3, -2 - 5j)


def test_a_pair_dragged_to_the_axis_becomes_real():
    assert move_pole((-1 + 2j, -1 - 2j), 0, -2 + 0.05j, axis_snap=0.1) == (-2, -2)


def test_a_real_pole_dragged_off_the_axis_takes_the_nearest_one_along():
    assert move_pole((-1, -5, -2), 0, -1.2 + 1j, axis_snap=0.1) == (-1.2 + 1j, -5, -1.2 - 1j)
    assert move_pole((-1, -5, -2), 0, -1.2 + 1j, axis_snap=0.1, fixed=(2,)) == (-1.2 + 1j, -1.2 - 1j, -2)


def test_a_lone_real_pole_stays_on_the_axis():
    assert move_pole((-1, -2 + 1j, -2 - 1j), 0, -3 + 4j, axis_snap=0.1) == (-3, -2 + 1j, -2 - 1j)


def test_fixed_poles_do_not_move():
    assert move_pole((-1, 2), 1, -3, axis_snap=0.1, fixed=(1,)) == (-1, 2)
    assert move_pole((-1 + 1j, -1 - 1j), 0, -3, axis_snap=0.1, fixed=(1,)) == (-1 + 1j, -1 - 1j)


@pytest.mark.parametrize(("index", "to", "refusal"), [
    (2, -1, PoleError), (-1, -1, PoleError), (0, np.nan, EngineError), (0, complex(0, np.inf), PoleError)])
def test_senseless_moves_are_refused(index, to, refusal):
    with pytest.raises(refusal):
        move_pole((-1, -2), index, to, axis_snap=0.1)


@settings(max_examples=200)
@given(
    moves=st.lists(st.tuples(st.integers(0, 4), st.floats(-9, 1), st.floats(-5, 5)), max_size=12),
    snap=st.sampled_from([0.0, 0.2]),
)
def test_any_sequence_of_moves_keeps_the_set_closed_under_conjugation(moves, snap):
    poles = (-1, -2 + 1j, -2 - 1j, -2 + 1j, -2 - 1j)
    for index, real, imag in moves:
        poles = move_pole(poles, index, complex(real, imag), axis_snap=snap)
    np.testing.assert_array_equal(check_poles(poles, 5), poles)
    assert Counter(np.conj(poles).tolist()) == Counter(poles)


def largest_step_of_the_gain(seed, m, count):
    """max ‖ΔK‖/‖K‖ while a pair is dragged by 0.45 in `count` steps: six states, m inputs."""
    A, B = random_pair(seed, 6, m)
    gains = []
    for t in np.linspace(0, 0.2, count + 1):
        poles = move_pole((-1 + 2j, -1 - 2j, -2, -3, -4, -5), 0, -1 - t + 1j * (2 + 2 * t), axis_snap=0.1)
        gains.append(place(A, B, poles).gain)
    return np.linalg.norm(np.diff(gains, axis=0), axis=(1, 2)).max() / np.linalg.norm(gains[0])


@pytest.mark.parametrize("seed", range(3))
def test_with_one_input_halving_the_step_of_the_hand_halves_the_step_of_the_gain(seed):
    assert largest_step_of_the_gain(seed, 1, 40) == pytest.approx(largest_step_of_the_gain(seed, 1, 20) / 2, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("m", "bound"), [(2, 0.05), (3, 0.01)])
def test_with_several_inputs_the_gain_follows_a_dragged_pole(m, bound):
    """Sixty small steps of the hand are small steps of K; two minima may change places, hence the median."""
    assert np.median([largest_step_of_the_gain(seed, m, 60) for seed in range(8, 15)]) < bound


def test_the_same_request_always_gives_the_same_gain():
    A, B = random_pair(3, 6, 3)
    poles = random_poles(3, 6, 2)
    np.testing.assert_array_equal(place(A, B, poles).gain, place(A.copy(), B.copy(), list(poles)).gain)
