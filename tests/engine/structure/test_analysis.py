"""Laws of observability and controllability: PBH, staircase, duality, invariance."""

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.engine import EngineError, Plant, controllability, observability
from observer_lab.engine.structure.decomposition import balanced_staircase, clearly_reached

SEEDS = st.integers(0, 2**32 - 1)


def rotation(rng, n):
    return np.linalg.qr(rng.standard_normal((n, n)))[0]


def with_hidden_part(rng, seen, hidden, p):
    """Observable (A1, C1) and a hidden block below it, in random orthogonal coordinates; the hidden poles too."""
    n = seen + hidden
    A = np.zeros((n, n))
    A[:seen, :seen] = rng.standard_normal((seen, seen))
    A[seen:] = rng.standard_normal((hidden, n))
    C = np.hstack([rng.standard_normal((p, seen)), np.zeros((p, hidden))])
    Q = rotation(rng, n)
    return Plant(Q @ A @ Q.T, np.zeros((n, 1)), C @ Q.T), np.linalg.eigvals(A[seen:, seen:])


def farthest_match(found, expected):
    from scipy.optimize import linear_sum_assignment

    cost = np.abs(np.subtract.outer(np.asarray(found), np.asarray(expected)))
    return cost[linear_sum_assignment(cost)].max(initial=0.0)


def test_published_two_by_two():
    report = observability(Plant([[1, 2], [3, 4]], [[0], [1]], [[1, 0]]))
    np.testing.assert_array_equal(report.matrix, [[1, 0], [1, 2]])
    assert report.rank == 2 and report.observable and report.detectable
    np.testing.assert_allclose(report.singular_values, [2.2882, 0.8740], atol=5e-5)
    np.testing.assert_allclose([mode.pole for mode in report.modes], [-0.37228, 5.37228], atol=5e-6)
    assert [mode.stable for mode in report.modes] == [True, False]


def test_twenty_visible_modes_are_seen_although_rank_of_O_is_seven():
    report = observability(Plant(np.diag(-np.arange(1.0, 21.0)), np.ones((20, 1)), np.ones((1, 20))))
    assert report.matrix_rank() == 7
    assert report.rank == 20 and report.observable
    assert min(mode.distance for mode in report.modes) > 0.4


@pytest.mark.parametrize("epsilon", [1e-1, 1e-4, 1e-8])
def test_near_unobservable_margin_shrinks_with_the_gap(epsilon):
    report = observability(Plant(np.diag([-1, -1 - epsilon]), [[1], [1]], [[1, 1]]))
    assert report.observable
    exact = np.linalg.svd([[0, 0], [0, -epsilon], [1, 1]], compute_uv=False)[-1]
    weakest = report.weakest
    assert weakest is not None
    assert weakest.distance == pytest.approx(exact, rel=1e-6)
    assert 0.5 * epsilon < weakest.distance < epsilon


def test_distance_is_reached_by_a_perturbation_that_hides_the_mode():
    A, C = np.array([[1.0, 2], [3, 4]]), np.array([[1.0, 0]])
    mode = observability(Plant(A, [[0], [1]], C)).modes[1]
    U, s, Vt = np.linalg.svd(np.vstack([A - mode.pole.real * np.eye(2), C]))
    change = s[-1] * np.outer(U[:, 1], Vt[-1])
    assert np.linalg.norm(change, 2) == pytest.approx(mode.distance)
    hidden = observability(Plant(A - change[:2], [[0], [1]], C - change[2:])).unobservable
    assert farthest_match(hidden, [mode.pole]) < 1e-9 and len(hidden) == 1


def test_repeated_pole_with_one_trace_is_half_hidden():
    report = observability(Plant(-np.eye(2), np.eye(2), [[1, 0]]))
    assert [mode.visible for mode in report.modes].count(False) == 1
    assert report.unobservable == (-1,) and report.rank == 1 and report.detectable


@pytest.mark.parametrize("copies", [2, 3, 5])
def test_equal_poles_need_as_many_outputs(copies):
    plant = Plant(2 * np.eye(copies), np.eye(copies), np.ones((1, copies)))
    report = observability(plant)
    np.testing.assert_allclose(report.unobservable, [2] * (copies - 1))
    assert not report.detectable
    assert controllability(plant).controllable


def test_a_jordan_block_is_seen_from_its_end_only():
    A = np.diag([-1.0] * 3) + np.diag([1.0, 1.0], 1)
    assert observability(Plant(A, np.ones((3, 1)), [[1, 0, 0]])).rank == 3
    assert observability(Plant(A, np.ones((3, 1)), [[0, 1, 0]])).rank == 2
    assert observability(Plant(A, np.ones((3, 1)), [[0, 0, 1]])).rank == 1


@pytest.mark.parametrize(("pole", "dt", "fine"), [(-0.5, 0.0, True), (0.5, 0.0, False), (0.0, 0.0, False),
                                                  (-0.5, 0.1, True), (0.5, 0.1, True), (1.0, 0.1, False),
                                                  (-1.5, 0.1, False)])
def test_detectable_and_stabilizable_ask_where_the_hidden_pole_lies(pole, dt, fine):
    plant = Plant(np.diag([-0.3, pole]), [[1], [0]], [[1, 0]], dt=dt)
    assert observability(plant).detectable is fine
    assert controllability(plant).stabilizable is fine
    assert not observability(plant).observable and not controllability(plant).controllable


@given(SEEDS, st.integers(1, 6), st.integers(0, 5), st.integers(1, 3))
@settings(max_examples=80)
def test_hidden_poles_are_found_in_any_coordinates(seed, seen, hidden, p):
    plant, expected = with_hidden_part(np.random.default_rng(seed), seen, hidden, p)
    report = observability(plant)
    assert report.rank == seen
    assert farthest_match(report.unobservable, expected) < 1e-5
    assert all(mode.distance < 1e-9 for mode in report.modes if not mode.visible)
    assert report.detectable == bool(np.all(expected.real < 0))


@given(SEEDS, st.integers(1, 8), st.integers(1, 3), st.integers(0, 2))
@settings(max_examples=60)
def test_duality_swaps_the_two_reports(seed, n, p, hidden):
    rng = np.random.default_rng(seed)
    plant = with_hidden_part(rng, n, hidden, p)[0]
    seen, reached = observability(plant), controllability(plant.dual())
    assert seen.modes == reached.modes and seen.rank == reached.rank
    np.testing.assert_array_equal(seen.matrix, reached.matrix.T)
    assert seen.unobservable == reached.uncontrollable and seen.detectable == reached.stabilizable


@given(SEEDS, st.integers(1, 6), st.integers(1, 3))
@settings(max_examples=40)
def test_matrices_agree_with_the_fields_own_library(seed, n, k):
    rng = np.random.default_rng(seed)
    A, B, C = rng.standard_normal((n, n)), rng.standard_normal((n, k)), rng.standard_normal((k, n))
    plant = Plant(A, B, C)
    np.testing.assert_allclose(observability(plant).matrix, control.obsv(A, C), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(controllability(plant).matrix, control.ctrb(A, B), rtol=1e-9, atol=1e-9)


@given(SEEDS, st.integers(1, 5), st.integers(0, 3),
       st.lists(st.integers(-6, 6), min_size=8, max_size=8), st.floats(-9, 9), st.floats(-6, 6))
@settings(max_examples=60)
def test_units_of_state_output_and_time_hide_nothing(seed, seen, hidden, powers, output, time):
    """Hidden stays hidden and seen stays seen when metres become nanometres and seconds become hours."""
    plant, _ = with_hidden_part(np.random.default_rng(seed), seen, hidden, 2)
    d = 10.0 ** np.array(powers[:plant.n])
    A = 10.0**time * plant.A * d / d[:, None]
    assert observability(Plant(A, plant.B, 10.0**output * plant.C * d)).rank == seen


def test_a_second_sensor_in_small_units_still_sees():
    report = observability(Plant(np.diag([-1.0, -2.0]), np.eye(2), [[1, 0], [0, 1e-12]]))
    assert report.observable and report.rank == 2


@given(SEEDS, st.integers(1, 6))
@settings(max_examples=40)
def test_margins_are_the_same_in_orthogonal_coordinates_and_gain(seed, n):
    rng = np.random.default_rng(seed)
    A, C, Q = rng.standard_normal((n, n)), rng.standard_normal((1, n)), rotation(rng, n)
    first = observability(Plant(A, np.zeros((n, 1)), C)).modes
    second = observability(Plant(3 * Q @ A @ Q.T, np.zeros((n, 1)), 3 * C @ Q.T)).modes
    for one in first:
        twin = min(second, key=lambda mode: abs(mode.pole - 3 * one.pole))
        assert twin.margin == pytest.approx(one.margin, rel=1e-4, abs=1e-6)
        assert twin.distance == pytest.approx(3 * one.distance, rel=1e-4, abs=1e-6)


def test_modes_are_sorted_by_real_then_imaginary_part():
    pair = np.array([[0, 1], [-1, 0]])
    A = np.kron(np.diag([1.0, 2.0]), pair) + np.diag([-1.0, -1.0, -2.0, -2.0])
    poles = [mode.pole for mode in observability(Plant(A, np.ones((4, 1)), np.ones((1, 4)))).modes]
    np.testing.assert_allclose(poles, [-2 - 2j, -2 + 2j, -1 - 1j, -1 + 1j], atol=1e-12)


def test_records_are_read_only():
    report = controllability(Plant(-np.eye(2), np.eye(2), np.eye(2)))
    with pytest.raises(ValueError, match="read-only"):
        report.matrix[0, 0] = 5


@pytest.mark.parametrize("rtol", [-1e-3, 1.0, np.nan])
def test_absurd_tolerance_is_refused(rtol):
    with pytest.raises(EngineError, match="rtol"):
        observability(Plant([[-1]], [[1]], [[1]]), rtol=rtol)


def test_overflowing_powers_are_a_sentence():
    with pytest.raises(EngineError, match="unit of time"):
        observability(Plant(1e200 * np.eye(3), np.ones((3, 1)), np.ones((1, 3)))).matrix  # noqa: B018


@settings(max_examples=60)
@given(seed=SEEDS, seen=st.integers(1, 6), hidden=st.integers(1, 4), p=st.integers(1, 3), size=st.floats(-6, 6))
def test_the_first_look_never_sees_a_hidden_state(seed, seen, hidden, p, size):
    plant, _ = with_hidden_part(np.random.default_rng(seed), seen, hidden, p)
    assert not clearly_reached(plant.A.T * 10**size, plant.C.T / 10**size)


@settings(max_examples=60)
@given(seed=SEEDS, n=st.integers(1, 8), p=st.integers(1, 3), rtol=st.sampled_from([0.0, 1e-10, 1e-3]))
def test_the_first_look_says_what_the_staircase_says(seed, n, p, rtol):
    rng = np.random.default_rng(seed)
    A, B = rng.standard_normal((n, n)), rng.standard_normal((n, p))
    assert not clearly_reached(A, B, rtol) or balanced_staircase(A, B, rtol)[2] == n


@settings(max_examples=40)
@given(seed=SEEDS, seen=st.integers(1, 40), hidden=st.integers(0, 20), p=st.integers(1, 4))
def test_the_staircase_turns_states_and_leaves_none_between(seed, seen, hidden, p):
    rng = np.random.default_rng(seed)
    plant, _ = with_hidden_part(rng, seen, hidden, p)
    scale, Q, rank = balanced_staircase(plant.A.T, plant.C.T)
    turned = Q.T @ (plant.A.T * scale / scale[:, None]) @ Q
    np.testing.assert_allclose(Q.T @ Q, np.eye(plant.n), atol=1e-12)
    assert np.abs(turned[rank:, :rank]).max(initial=0.0) <= 1e-8 * np.linalg.norm(turned)
    assert np.abs((Q.T @ (plant.C.T / scale[:, None]))[rank:]).max(initial=0.0) <= 1e-8 * np.abs(plant.C.T / scale[:, None]).max()
