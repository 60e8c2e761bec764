"""Estimate feedback: separation, the compensator against python-control's loop, Doyle's vanishing margin."""

import control
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from observer_lab.engine import Plant, ShapeError, closed_loop, compensator, lqe, lqr, observer_gain, place
from observer_lab.engine.feedback import to_tf
from observer_lab.engine.systems import is_stable, match_poles


def random_plant(seed, n, m, p, through=0.0, dt=0.0):
    rng = np.random.default_rng(seed)
    A, B, C = rng.standard_normal((n, n)), rng.standard_normal((n, m)), rng.standard_normal((p, n))
    return Plant(A, B, C, through * rng.standard_normal((p, m)), dt)


def gains(plant):
    n = plant.n
    K = place(plant.A, plant.B, -1.0 - np.arange(n)).gain
    return K, observer_gain(plant.A, plant.C, -1.5 - n - np.arange(n)).gain


SPRING = Plant([[0, 1], [-1, -0.5]], [[0], [1]], [[1, 0]], None, 0.0, ("q", "v"), ("F",), ("y",))


# --- separation ------------------------------------------------------------------------------------------------------


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), n=st.integers(1, 5), m=st.integers(1, 2), p=st.integers(1, 2))
def test_separation_the_loop_has_the_poles_of_controller_and_observer(seed, n, m, p):
    plant = random_plant(seed, n, m, p, through=1.0)
    K, L = gains(plant)
    assume(np.linalg.norm(K) < 200 and np.linalg.norm(L) < 200)
    loop = closed_loop(plant, K, L)
    union = np.concatenate([np.linalg.eigvals(plant.A - plant.B @ K), np.linalg.eigvals(plant.A - L @ plant.C)])
    assert match_poles(union, np.linalg.eigvals(loop.A_xxhat))[1] <= 1e-4 * np.abs(union).max()
    assert loop.polynomial_error < 1e-7
    np.testing.assert_array_equal(loop.A_xe[n:, :n], 0)  # e never hears of x
    assert loop.stable and len(loop.poles) == 2 * n


def test_separation_to_nine_digits_on_good_plants():
    for seed in range(5):
        plant = random_plant(seed, 4, 2, 2)
        K = lqr(plant.A, plant.B, np.eye(4), np.eye(2)).gain
        L = lqe(plant.A, np.eye(4), plant.C, 7 * np.eye(4), np.eye(2)).gain
        assert closed_loop(plant, K, L).union_error < 1e-9


def test_multiple_poles_are_judged_by_their_polynomial():
    """Eight poles at −2 scatter by ε^(1/8); the polynomial tells that they are right all the same."""
    chain = Plant(np.eye(4, k=1), np.eye(4)[:, -1:], np.eye(4)[:1])
    K, L = place(chain.A, chain.B, [-2] * 4).gain, observer_gain(chain.A, chain.C, [-2] * 4).gain
    loop = closed_loop(chain, K, L)
    assert loop.union_error > 1e-6
    assert loop.polynomial_error < 1e-11


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), n=st.integers(1, 5), m=st.integers(1, 3), p=st.integers(1, 3))
def test_both_coordinates_describe_one_system_whatever_the_model(seed, n, m, p):
    plant, model = random_plant(seed, n, m, p, 1.0), random_plant(seed + 1, n, m, p, 1.0)
    rng = np.random.default_rng(seed)
    K, L = rng.standard_normal((m, n)), rng.standard_normal((n, p))
    loop = closed_loop(plant, K, L, model=model)
    np.testing.assert_allclose(loop.T @ loop.A_xxhat @ np.linalg.inv(loop.T), loop.A_xe, atol=1e-11 * (1 + n * m * p))
    believed = closed_loop(model, K, L)
    np.testing.assert_array_equal(loop.controller_poles, believed.controller_poles)
    np.testing.assert_array_equal(loop.observer_poles, believed.observer_poles)


def test_a_wrong_model_breaks_separation():
    wrong = Plant([[0, 1], [-1.5, -0.5]], SPRING.B, SPRING.C)
    loop = closed_loop(SPRING, [[1, 1]], [[1.5], [-0.75]], model=wrong)
    assert np.abs(loop.A_xe[2:, :2]).max() > 0.4
    assert loop.union_error > 0.01


def test_spring_damper_loop_in_numbers():
    loop = closed_loop(SPRING, [[3, 3.5]], [[1.5], [-0.75]])
    np.testing.assert_allclose(loop.A_xe, [[0, 1, 0, 0], [-4, -4, 3, 3.5], [0, 0, -1.5, 1], [0, 0, -0.25, -0.5]])
    np.testing.assert_allclose(loop.controller_poles, [-2, -2], atol=1e-7)
    np.testing.assert_allclose(loop.observer_poles, [-1, -1], atol=1e-7)


# --- the compensator -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dt", [0.0, 0.1])
@pytest.mark.parametrize("seed", range(4))
def test_the_loop_closed_by_python_control_has_the_same_poles(seed, dt):
    plant = random_plant(seed, 3, 2, 2, through=0.5, dt=dt)
    model = Plant(plant.A * 1.05, plant.B * 0.9, plant.C, plant.D + 0.1, dt)
    rng = np.random.default_rng(seed)
    K, L = rng.standard_normal((2, 3)), rng.standard_normal((3, 2))
    loop = closed_loop(plant, K, L, model=model)
    C = loop.compensator
    theirs = control.feedback(
        control.StateSpace(plant.A, plant.B, plant.C, plant.D, dt), control.StateSpace(C.A, C.B, C.C, C.D, dt), sign=1
    )
    assert match_poles(loop.poles, theirs.poles())[1] < 1e-9
    assert C.dt == dt


def test_the_compensator_is_named_after_the_signals_it_joins():
    built = compensator(SPRING, [[1, 2]], [[1.5], [-0.75]])
    assert (built.input_names, built.output_names, built.state_names) == (("y",), ("F",), ("q_hat", "v_hat"))


def test_a_stable_loop_may_need_an_unstable_compensator():
    """(s − 1)/(s² − 4) is not strongly stabilisable: one pole, 2, between its unstable zeros 1 and ∞."""
    plant = Plant([[0, 1], [4, 0]], [[0], [1]], [[-1, 1]])
    K, L = gains(plant)
    loop = closed_loop(plant, K, L)
    assert loop.stable and not loop.compensator_stable
    calm = closed_loop(SPRING, [[1, 1]], [[1.5], [-0.75]])
    assert calm.stable and calm.compensator_stable


def test_stability_is_judged_by_the_unit_circle_in_discrete_time():
    slow = Plant(0.5, 1, 1, dt=0.1)
    loop = closed_loop(slow, 0.2, 0.3)
    assert loop.stable and loop.compensator_stable
    assert not closed_loop(Plant(-1.2, 1, 1, dt=0.1), 0, 0).stable


@pytest.mark.parametrize(("q", "sigma"), [(1.0, 1.0), (60.0, 60.0), (1000.0, 10.0)])
def test_doyle_1978_the_gain_margin_is_one_over_df(q, sigma):
    """With the input gain off by the factor m the loop is stable up to exactly m = 1 + 1/(df)."""
    model = Plant([[1, 1], [0, 1]], [[0], [1]], [[1, 0]])
    K = lqr(model.A, model.B, q * np.ones((2, 2)), 1).gain
    L = lqe(model.A, [[1], [1]], model.C, sigma, 1).gain
    edge = 1 + 1 / ((2 + np.sqrt(4 + q)) * (2 + np.sqrt(4 + sigma)))
    for factor, stable in ((edge - 1e-6, True), (edge + 1e-6, False)):
        truth = Plant(model.A, factor * model.B, model.C)
        assert closed_loop(truth, K, L, model=model).stable is stable


# --- transfer functions ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_transfer_function_equals_the_resolvent(seed):
    plant = random_plant(seed, 4, 2, 3, through=float(seed % 2))
    H = to_tf(plant)
    assert H.num.shape == (3, 2, 5) and H.den.shape == (5,)
    for s in (0.3, 1j, 2 - 1j, -0.7 + 5j):
        direct = plant.C @ np.linalg.solve(s * np.eye(4) - plant.A, plant.B) + plant.D
        np.testing.assert_allclose(H(s), direct, rtol=1e-9, atol=1e-11)


def test_coefficients_that_vanish_by_structure_are_exact_zeros():
    H = to_tf(Plant(np.eye(3, k=1), [[0], [0], [2]], [[1, 0, 0]]))
    np.testing.assert_array_equal(H.num[0, 0, :3], 0)
    np.testing.assert_allclose(H.num[0, 0, 3], 2, rtol=1e-13)
    np.testing.assert_array_equal(H.den, [1, 0, 0, 0])


def test_the_spring_damper_compensator_by_hand():
    """u = −K(sI − A + BK + LC)⁻¹L y with K = (1, 1), L = (3/2, −3/4), by hand."""
    H = to_tf(compensator(SPRING, [[1, 1]], [[1.5], [-0.75]]))
    # A − BK − LC = [[−1.5, 1], [−1.25, −1.5]]: det(sI − ·) = s² + 3 s + 3.5; adjugate·L = (1.5 s + 1.5, −0.75 s − 3)
    np.testing.assert_allclose(H.den, [1, 3, 3.5], rtol=1e-13)
    np.testing.assert_allclose(H.num[0, 0], [0, -0.75, 1.5], rtol=1e-12)


def test_gains_and_models_that_do_not_fit_are_refused():
    for call in (
        lambda: compensator(SPRING, [[1, 1, 1]], [[1], [1]]),
        lambda: compensator(SPRING, [[1, 1]], [[1, 1]]),
        lambda: closed_loop(SPRING, [[1, 1]], [[1], [1]], model=Plant(1, 1, 1)),
        lambda: closed_loop(SPRING, [[1, 1]], [[1], [1]], model=Plant(SPRING.A, SPRING.B, SPRING.C, dt=0.1)),
    ):
        with pytest.raises(ShapeError):
            call()


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), n=st.integers(1, 5), dt=st.sampled_from([0.0, 0.1]))
def test_a_loop_on_its_own_model_is_judged_as_its_matrix_is(seed, n, dt):
    plant = random_plant(seed, n, 1, 1, through=1.0, dt=dt)
    rng = np.random.default_rng(seed)
    for K, L in ((rng.standard_normal((1, n)), rng.standard_normal((n, 1))), (np.zeros((1, n)), np.zeros((n, 1)))):
        loop = closed_loop(plant, K, L)
        assert loop.stable == is_stable(loop.A_xe, dt=dt)
        assert loop.compensator_stable == is_stable(compensator(plant, K, L).A, dt=dt)
        np.testing.assert_array_equal(loop.compensator_poles, compensator(plant, K, L).poles)
