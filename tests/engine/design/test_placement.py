"""Pole placement: laws and published gains."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp
from pole_requests import POSITION, SPRING, random_pair, random_poles, same_polynomial

from observer_lab.engine import observer_gain, place
from observer_lab.engine.systems import balance


# --- published numbers ---------------------------------------------------------------------------------------------
def test_spring_damper_double_pole_with_one_output():
    placed = observer_gain(SPRING, POSITION, [-1, -1])
    np.testing.assert_allclose(placed.gain, [[1.5], [-0.75]], rtol=0, atol=1e-14)
    assert placed.condition == np.inf  # a double pole with one output is always defective
    assert placed.error < 1e-6


@pytest.mark.parametrize(
    ("poles", "gain"),
    [
        ([(-3 - 5**0.5) / 2, (-3 + 5**0.5) / 2], [2.5, -1.25]),  # the printed gain, taken literally: −2.618, −0.382
        ([(-3 - 3**0.5) / 2, (-3 + 3**0.5) / 2], [2.5, -0.75]),  # the printed A − LC: −2.366, −0.634
    ],
)
def test_spring_damper_slips_of_the_source(poles, gain):
    np.testing.assert_allclose(observer_gain(SPRING, POSITION, poles).gain.ravel(), gain, atol=1e-13)


def test_double_integrator_gains():
    chain, force = [[0, 1], [0, 0]], [[0], [1]]
    np.testing.assert_allclose(place(chain, force, [-2, -2]).gain, [[4, 4]], atol=1e-13)
    np.testing.assert_allclose(observer_gain(chain, [[1, 0]], [-6, -6]).gain, [[12], [36]], atol=1e-12)


def test_chain_of_integrators_gives_the_coefficients_of_the_polynomial():
    """x⁽⁶⁾ = u: K holds the coefficients of ∏(s − λ), lowest first, here with multiplicities 3, 2 and 1."""
    A, B = np.eye(6, k=1), np.eye(6)[:, -1:]
    poles = [-1, -1, -1, -2, -2, -3]
    np.testing.assert_allclose(place(A, B, poles).gain[0], np.poly(poles)[:0:-1], rtol=1e-11)


def ackermann(A, b, poles):
    """Ackermann's formula in fifty digits: the oracle for one input."""
    with mp.workdps(50):
        n = len(poles)
        M, c = mp.matrix(A.tolist()), mp.matrix(b.tolist())
        krylov, column = mp.matrix(n, n), c
        for j in range(n):
            krylov[:, j] = column
            column = M * column
        value = mp.eye(n)
        for pole in poles:
            value = value * (M - mp.mpc(pole) * mp.eye(n))
        last = mp.lu_solve(krylov.T, mp.eye(n)[:, n - 1])
        return np.array([float(mp.re(x)) for x in (last.T * value)])


@pytest.mark.parametrize("seed", range(6))
def test_one_input_agrees_with_ackermann_in_fifty_digits(seed):
    A, b = random_pair(seed, 6, 1)
    poles = [[-1, -2, -3, -4, -5, -6], [-1, -1, -1, -2, -2, -2], [-1 + 2j, -1 - 2j, -1 + 2j, -1 - 2j, -3, -3]][seed % 3]
    exact = ackermann(A, b, poles)
    assert np.linalg.norm(place(A, b, poles).gain[0] - exact) < 1e-8 * np.linalg.norm(exact)


# --- laws ----------------------------------------------------------------------------------------------------------
@settings(max_examples=60)
@given(seed=st.integers(0, 10_000), n=st.integers(1, 8), m=st.integers(1, 4), pairs=st.integers(0, 2))
def test_the_poles_asked_for_are_reached(seed, n, m, pairs):
    A, B = random_pair(seed, n, m)
    poles = random_poles(seed, n, min(pairs, n // 2))
    placed = place(A, B, poles)
    assume(np.linalg.norm(placed.gain) < 1e4)
    assert placed.gain.shape == (m, n)
    np.testing.assert_array_equal(placed.asked, poles)
    backward = np.finfo(float).eps * (np.linalg.norm(A) + np.linalg.norm(B) * np.linalg.norm(placed.gain))
    assert placed.error < 100 * placed.condition * backward  # the bound of Bauer and Fike
    rounding = np.finfo(float).eps * np.abs(poles).max()
    assert abs(np.abs(placed.reached - placed.asked).max() - placed.error) <= rounding  # matched by index, not sorted
    same_polynomial(A - B @ placed.gain, poles, 1e-8)


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), n=st.integers(2, 6), m=st.integers(1, 3), multiplicity=st.integers(2, 6))
def test_multiple_poles_are_reached_whatever_their_multiplicity(seed, n, m, multiplicity):
    A, B = random_pair(seed, n, m)
    k = min(multiplicity, n)
    poles = np.concatenate([np.full(k, -1.5), -2.0 - np.arange(n - k)])
    placed = place(A, B, poles)
    assume(np.linalg.norm(placed.gain) < 1e4)
    same_polynomial(A - B @ placed.gain, poles, 1e-7)
    assert (placed.condition == np.inf) == (k > m)


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), n=st.integers(2, 7), p=st.integers(1, 3))
def test_duality_observer_gain_moves_the_poles_of_A_minus_LC(seed, n, p):
    A, C = random_pair(seed, n, p)
    C = C.T
    poles = random_poles(seed, n, 1)
    placed = observer_gain(A, C, poles)
    assume(np.linalg.norm(placed.gain) < 1e4)
    assert placed.gain.shape == (n, p)
    same_polynomial(A - placed.gain @ C, poles, 1e-8)
    np.testing.assert_allclose(placed.gain, place(A.T, C.T, poles).gain.T)


@pytest.mark.slow
@settings(max_examples=30)
@given(seed=st.integers(0, 10_000), n=st.integers(2, 5), shift=st.floats(-3, 3))
def test_with_one_input_the_gain_depends_on_neither_order_nor_coordinates_nor_shift(seed, n, shift):
    A, b = random_pair(seed, n, 1)
    poles = random_poles(seed, n, 1)
    K = place(A, b, poles).gain
    size = np.linalg.norm(K)
    assume(size < 1e3)
    T = np.linalg.qr(np.random.default_rng(seed).standard_normal((n, n)))[0] * np.linspace(0.5, 2, n)
    tolerance = 1e-8 * size
    np.testing.assert_allclose(place(A, b, poles[::-1]).gain, K, rtol=0, atol=tolerance)
    np.testing.assert_allclose(place(A + shift * np.eye(n), b, poles + shift).gain, K, rtol=0, atol=tolerance)
    np.testing.assert_allclose(
        place(np.linalg.solve(T, A @ T), np.linalg.solve(T, b), poles).gain, K @ T, rtol=0, atol=2 * tolerance
    )


def in_balanced_states(A, B):
    """The pair in the states in which `place` judges eigenvectors."""
    scale = balance(A, B).unrounded[:len(A)]
    return A * scale / scale[:, None], B / scale[:, None]


def test_as_many_inputs_as_states_give_orthogonal_eigenvectors():
    A, B = random_pair(3, 4, 4)
    placed = place(A, B, [-1 + 1j, -1 - 1j, -2, -2])
    scale = balance(A, B).unrounded[:4]
    closed = (A - B @ placed.gain) * scale / scale[:, None]
    np.testing.assert_allclose(closed @ closed.T, closed.T @ closed, atol=1e-12)  # normal
    assert np.linalg.cond(np.linalg.eig(closed)[1][:, :2]) == pytest.approx(1.0)


def test_condition_is_that_of_the_unit_eigenvectors():
    A, B = random_pair(5, 6, 2)
    placed = place(A, B, [-1, -2, -3, -4, -2 + 3j, -2 - 3j])
    X = np.linalg.eig(A - B @ placed.gain)[1]
    assert placed.condition == pytest.approx(np.linalg.cond(X), rel=1e-6)


def test_condition_beside_scipy_on_random_plants():
    """Tits and Yang's method maximises the determinant of the eigenvectors: ours must be as well conditioned."""
    from scipy.signal import place_poles

    ratios = []
    for seed in range(8):
        A, B = in_balanced_states(*random_pair(seed, 6, 3))
        poles = random_poles(seed, 6, seed % 3)
        peer = place_poles(A, B, poles, method="YT")
        X = np.linalg.eig(A - B @ place(A, B, poles).gain)[1]
        ratios.append(np.linalg.cond(X) / np.linalg.cond(peer.X))
    assert np.median(ratios) <= 0.9
    assert max(ratios) <= 1.05


def test_badly_scaled_units_do_not_make_a_plant_uncontrollable():
    A, B = random_pair(1, 4, 1)
    scale = np.array([1e-6, 1.0, 1e3, 1e6])
    poles = [-1, -2, -3, -4]
    K = place(A * scale[:, None] / scale, B * scale[:, None] * 1e-9, poles).gain
    np.testing.assert_allclose(K * scale * 1e-9, place(A, B, poles).gain, rtol=1e-6)


def test_nearly_uncontrollable_twins_ask_for_a_gain_that_grows_like_one_over_epsilon():
    """diag(−1, −1−ε), both moved to −2 ± 1 by one input: the gain is of order 1/ε, not refused and not wrong."""
    for eps in (1e-2, 1e-4, 1e-6):
        A, B = np.diag([-1.0, -1.0 - eps]), np.ones((2, 1))
        K = place(A, B, [-1.0, -3.0]).gain
        # k1 + k2 = 2 − ε and k1(1+ε) + k2 = 2 − ε … solved by hand: k1 = 0 keeps −1, k2 = 2 − ε
        np.testing.assert_allclose(K, [[0.0, 2.0 - eps]], atol=1e-9 / eps)
        moved = place(A, B, [-2.0, -2.0]).gain
        assert np.linalg.norm(moved) * eps == pytest.approx(np.sqrt(2), rel=2 * eps)


def test_dependent_inputs_count_once():
    A, b = random_pair(2, 4, 1)
    poles = [-1, -2, -3, -4]
    K = place(A, np.hstack([b, 2 * b, np.zeros((4, 1))]), poles).gain
    np.testing.assert_allclose(K[0] + 2 * K[1], place(A, b, poles).gain[0], rtol=1e-8)
    np.testing.assert_array_equal(K[2], 0)


def test_repeated_pairs_forbidden_by_rosenbrock_are_still_reached():
    """Controllability indices (3, 1): two double poles with four eigenvectors do not exist; defective ones do."""
    A = np.zeros((4, 4))
    A[0, 1] = A[1, 2] = 1.0
    B = np.zeros((4, 2))
    B[2, 0] = B[3, 1] = 1.0
    poles = [-1, -1, -2, -2]
    placed = place(A, B, poles)
    same_polynomial(A - B @ placed.gain, poles, 1e-10)
    assert placed.condition == np.inf
