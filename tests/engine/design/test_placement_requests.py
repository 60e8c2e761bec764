"""Pole placement: modes that no input moves, requests that must be refused, sets of poles that match."""

import numpy as np
import pytest
from pole_requests import SPRING

from observer_lab.engine import EngineError, PoleError, ShapeError, observer_gain, place
from observer_lab.engine.systems import check_poles, match_poles


# --- uncontrollable modes --------------------------------------------------------------------------------------------
def hidden_mode(seed, mode):
    """Four states, the last a mode at `mode` that the input does not reach, in coordinates that hide the fact."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((4, 4))
    A[3] = [0, 0, 0, mode]
    B = np.vstack([rng.standard_normal((3, 2)), np.zeros((1, 2))])
    T = np.linalg.qr(rng.standard_normal((4, 4)))[0]
    return T @ A @ T.T, T @ B


@pytest.mark.parametrize("seed", range(5))
def test_an_uncontrollable_mode_is_kept_and_the_others_are_moved(seed):
    A, B = hidden_mode(seed, 2.0)
    placed = place(A, B, [-1 + 1j, 2, -1 - 1j, -3])
    np.testing.assert_allclose(placed.fixed, [2.0], atol=1e-10)
    assert placed.error < 1e-8
    with pytest.raises(PoleError, match=r"mode at 2 is uncontrollable: no K can move it, so keep 2 among"):
        place(A, B, [-1, -2, -3, -4])
    with pytest.raises(PoleError, match=r"mode at 2 is unobservable: no L can move it, so keep 2 among"):
        observer_gain(A.T, B.T, [-1, -2, -3, -4])


@pytest.mark.parametrize("away, meant", [(0.0, True), (0.8e-5, True), (1.2e-5, False), (5e-3, False)])
def test_a_request_within_a_hundred_thousandth_of_a_fixed_mode_means_that_mode(away, meant):
    A, B = hidden_mode(0, 2.0)
    asked = [-1, -2, -3, 2 * (1 + away)]
    if meant:
        np.testing.assert_allclose(place(A, B, asked).fixed, [2.0], atol=1e-10)
    else:
        with pytest.raises(PoleError, match="mode at 2 is uncontrollable"):
            place(A, B, asked)


def test_no_input_at_all_leaves_every_pole_fixed():
    placed = place(np.diag([-1.0, -2.0]), np.zeros((2, 1)), [-2, -1])
    np.testing.assert_array_equal(placed.gain, [[0, 0]])
    assert sorted(placed.fixed.real) == [-2, -1]


def test_an_uncontrollable_pair_is_named():
    A = np.zeros((3, 3))
    A[:2, :2], A[2, 2] = [[0, 1], [-4, 0]], 1
    with pytest.raises(PoleError, match=r"mode at 0 [-+] 2j is uncontrollable"):
        place(A, [[0], [0], [1]], [-1, -2, -3])


# --- bad requests ----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("poles", "sentence"),
    [
        ([-1], "each state: 2, not"),
        ([-1, -2, -3], "each state: 2, not"),
        ([-1 + 1j, -2], "lacks its conjugate -1 - 1j"),
        ([-1 - 1j, -2], "lacks its conjugate -1 \\+ 1j"),
        ([-1 + 1j, -1 - 1.1j], "lacks its conjugate"),
        ([np.nan, -1], "NaN or infinite"),
        ([-np.inf, -1], "NaN or infinite"),
        ([-1e101, -1], "slower"),
        (["fast", -1], "must be numbers"),
        (None, "must be numbers"),
    ],
)
def test_requests_without_an_answer_are_refused_with_a_sentence(poles, sentence):
    with pytest.raises(PoleError, match=sentence):
        place(SPRING, [[0], [1]], poles)


def test_poles_too_far_apart_for_doubles_are_refused_with_a_sentence():
    with pytest.raises(EngineError, match="too large or too far apart"):
        place(SPRING, [[0], [1]], [-1e30, -1])


def test_matrices_that_do_not_fit_are_refused():
    with pytest.raises(ShapeError):
        place(SPRING, [[1], [2], [3]], [-1, -2])
    with pytest.raises(ShapeError):
        place([[1, 2, 3]], [[1]], [-1])
    with pytest.raises(EngineError):
        place([[np.nan, 1], [0, 0]], [[0], [1]], [-1, -2])


def test_rounding_in_a_pair_is_forgiven_and_made_exact():
    asked = check_poles([-1 + 1j, -1 - 1j * (1 + 1e-13)], 2)
    assert asked[1] == asked[0].conjugate()


# --- matching --------------------------------------------------------------------------------------------------------
def test_matching_respects_multiplicity_where_sorting_fails():
    a = np.array([-1 + 1j, -1 - 1j, -1 + 0.5j, -1 - 0.5j])
    b = np.array([-1.0000001 + 0.5j, -0.9999999 + 1j, -1 - 0.5j, -1.0000001 - 1j])
    order, distance = match_poles(a, b)
    assert distance < 2e-7
    np.testing.assert_allclose(b[order], a, atol=2e-7)
    assert match_poles([-1, -1, -2], [-1, -2, -2])[1] == 1.0
    with pytest.raises(PoleError):
        match_poles([1], [1, 2])
