"""Gains to start from, for any plant, and moving some poles while the others stay where they are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.engine import EngineError, Plant, PoleError, observability, place
from observer_lab.engine.design import in_natural_units, shift_observer, shift_poles, starting_feedback, starting_observer, typical_rate
from observer_lab.engine.systems import match_poles


def plant_of(seed: int, n: int, m: int, p: int, dt: float = 0.0) -> Plant:
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) * 10.0 ** rng.uniform(-1, 1)
    if dt:
        A /= max(1e-9, np.abs(np.linalg.eigvals(A)).max() / 1.1)
    return Plant(A, rng.standard_normal((n, m)), rng.standard_normal((p, n)), None, dt)


seeds, orders, few = st.integers(0, 100_000), st.integers(1, 10), st.integers(1, 3)


@pytest.mark.slow
@settings(max_examples=60, derandomize=True, database=None)
@given(seeds, orders, few, st.sampled_from([0.0, 0.1]))
def test_the_start_stabilises_what_can_be_and_says_which_poles_it_gives(seed: int, n: int, m: int, dt: float) -> None:
    plant = plant_of(seed, n, m, m, dt)
    K, L = starting_feedback(plant), starting_observer(plant)
    for found, closed in ((K, plant.A - plant.B @ K.gain), (L, plant.A - L.gain @ plant.C)):
        poles = np.linalg.eigvals(closed)
        assert match_poles(found.poles, poles)[1] < 1e-6 * max(1.0, np.abs(poles).max())
        assert not found.bolted.size
        assert np.all(np.abs(poles) < 1) if dt else np.all(poles.real < 0)


@pytest.mark.slow
@settings(max_examples=40, derandomize=True, database=None)
@given(seeds, st.integers(2, 8))
def test_units_of_the_signals_do_not_move_the_poles(seed: int, n: int) -> None:
    """The same plant in millimetres and in kilonewtons has the same starting poles."""
    plant = plant_of(seed, n, 2, 2)
    other = Plant(plant.A, 1e-3 * plant.B, 1e4 * plant.C)
    for start in (starting_feedback, starting_observer):
        assert match_poles(start(plant).poles, start(other).poles)[1] < 1e-6 * np.abs(start(plant).poles).max()


def test_the_unit_of_time_scales_the_poles_alike() -> None:
    plant = plant_of(3, 5, 1, 1)
    quick = Plant(1000 * plant.A, 1000 * plant.B, plant.C)
    slow, fast = starting_feedback(plant).poles, starting_feedback(quick).poles
    assert match_poles(1000 * slow, fast)[1] < 1e-6 * np.abs(fast).max()
    assert typical_rate(quick) == pytest.approx(1000 * typical_rate(plant))


def test_what_no_input_reaches_keeps_its_poles_stable_or_not() -> None:
    plant = Plant(np.diag([-1.0, 2.0, 3.0]), np.array([[1.0], [1.0], [0.0]]), np.eye(3))
    found = starting_feedback(plant)
    assert found.bolted == pytest.approx([3.0]) and np.all(found.moved.real < 0)
    nothing = starting_feedback(Plant(plant.A, np.zeros((3, 1)), plant.C))
    assert not nothing.gain.any() and not nothing.moved.size and nothing.bolted == pytest.approx([-1, 2, 3])


@pytest.mark.slow
@settings(max_examples=60, derandomize=True, database=None)
@given(seeds, st.integers(2, 12), few)
def test_moved_poles_move_and_the_others_stay(seed: int, n: int, m: int) -> None:
    plant = plant_of(seed, n, m, m)
    for dual in (False, True):
        found = starting_observer(plant) if dual else starting_feedback(plant)
        slow = found.moved[np.argmin(np.abs(found.moved))]
        group = [slow] if slow.imag == 0 else [slow, slow.conjugate()]
        after = [p for p in found.moved if not any(abs(p - g) < 1e-9 * abs(g) for g in group)] + [1.4 * g for g in group]
        shift = shift_observer if dual else shift_poles
        gain = shift(plant.A, plant.C if dual else plant.B, found.gain, found.moved, after)
        closed = plant.A - (gain @ plant.C if dual else plant.B @ gain)
        reached = np.linalg.eigvals(closed)
        rng, eps = np.random.default_rng(0), np.finfo(float).eps
        last_bit = match_poles(reached, np.linalg.eigvals(closed * (1 + eps * rng.choice([-1.0, 1.0], closed.shape))))[1]
        nearest = []  # what the last bits of the gain move: no gain that doubles can hold is surer
        for _ in range(8):
            other = gain * (1 + eps * rng.choice([-1.0, 1.0], gain.shape))
            nearest.append(match_poles(reached, np.linalg.eigvals(plant.A - (other @ plant.C if dual else plant.B @ other)))[1])
        assert match_poles(after, reached)[1] < max(1e-5 * np.abs(reached).max(), 4 * last_bit, *nearest)


@pytest.mark.slow
@settings(max_examples=30, derandomize=True, database=None)
@given(seeds, st.integers(2, 5))
def test_with_one_input_moving_all_poles_is_placing_them(seed: int, n: int) -> None:
    """The gain of one input is unique."""
    plant = plant_of(seed, n, 1, 1)
    found, asked = starting_feedback(plant), [-(1.0 + k) for k in range(n)]
    ours, wanted = shift_poles(plant.A, plant.B, found.gain, found.moved, asked), place(plant.A, plant.B, asked).gain
    assert np.abs(ours - wanted).max() < 1e-5 * max(1.0, np.abs(wanted).max())


def test_a_pair_of_thirty_is_moved_and_twenty_eight_stay() -> None:
    """A chain of fifteen masses with one force: dragging one pair must not disturb the other twenty-eight poles."""
    k = 15
    K = 2 * np.eye(k) - np.eye(k, k=1) - np.eye(k, k=-1)
    A = np.block([[np.zeros((k, k)), np.eye(k)], [-K, -0.1 * K]])
    B = np.zeros((2 * k, 1))
    B[k] = 1.0
    found = starting_feedback(Plant(A, B, np.eye(2 * k)))
    slow = found.moved[np.argmin(np.abs(found.moved))]
    after = [p for p in found.moved if abs(abs(p) - abs(slow)) > 1e-9] + [1.5 * slow, 1.5 * slow.conjugate()]
    gain = shift_poles(A, B, found.gain, found.moved, after)
    assert match_poles(after, np.linalg.eigvals(A - B @ gain))[1] < 1e-6


def test_nothing_moved_is_the_gain_itself_and_a_bolted_pole_is_refused() -> None:
    plant = Plant(np.diag([-1.0, 2.0, 3.0]), np.array([[1.0], [1.0], [0.0]]), np.eye(3))
    found = starting_feedback(plant)
    assert shift_poles(plant.A, plant.B, found.gain, found.moved, found.moved) is found.gain
    with pytest.raises(PoleError):
        shift_poles(plant.A, plant.B, found.gain, [3.0], [-3.0])
    with pytest.raises(PoleError, match="2, not 1"):
        shift_poles(plant.A, plant.B, found.gain, found.moved, [-1.0])


@pytest.mark.slow
@settings(max_examples=40, derandomize=True, database=None)
@given(seeds, st.integers(1, 8))
def test_natural_units_keep_poles_and_ranks_and_forget_the_units_of_a_file(seed: int, n: int) -> None:
    plant = plant_of(seed, n, 2, 2)
    scale = 2.0 ** np.random.default_rng(seed).integers(-12, 12, n)
    other = Plant(plant.A * scale / scale[:, None], 1e4 * plant.B / scale[:, None], 1e-5 * plant.C * scale)
    one, two = (observability(in_natural_units(p)) for p in (plant, other))
    assert match_poles([m.pole for m in one.modes], plant.poles)[1] < 1e-6 * np.abs(plant.poles).max()
    assert one.rank == observability(plant).rank == two.rank
    first, second = (np.sort([m.margin for m in report.modes]) for report in (one, two))
    assert np.all(np.abs(np.log2(first / second)) < 3)  # balancing stops within a factor of two in each state


def test_a_gain_that_is_asked_to_be_lazier_than_nothing_is_refused_and_not_zero() -> None:
    plant = plant_of(1, 3, 1, 1)
    for eager in (0.0, -1.0, np.nan):
        with pytest.raises(EngineError, match="eager must be"):
            starting_feedback(plant, eager=eager)
