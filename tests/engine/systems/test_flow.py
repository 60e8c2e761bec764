"""Nonlinear plants over a step: order four against scipy's integrator, slopes by hand against two other ways."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from observer_lab.engine import EngineError, NonlinearPlant, ShapeError
from observer_lab.engine.systems import Flow, slopes
from observer_lab.plants import cart_pendulum, growth
from observer_lab.plants.bodies import falling_body
from observer_lab.plants.platform import model, nonlinear

PLANTS = {
    "platform": (nonlinear.plant(nonlinear.NonlinearLaws(0.8, 0.4)), 0.03,
                 np.array([1.5e-3, 2e-3, 9e-3, 1e-2, 1.4e-2, 7e-2]), np.zeros(6)),
    "pendulum": (cart_pendulum.nonlinear_plant(cart_pendulum.Parameters(pivot=0.05), "both"), 0.05,
                 np.array([0.3, 0.6, 0.5, 1.0]), np.zeros(4)),
    "falling body": (falling_body.plant(), 1.0, np.array(falling_body.TRUE_START) * [0.1, 0.1, 0.3],
                     np.array(falling_body.TRUE_START)),
}
every_plant = pytest.mark.parametrize("name", PLANTS)


def case(name: str) -> tuple[NonlinearPlant, float, np.ndarray, np.ndarray]:
    plant, step, spread, middle = PLANTS[name]
    rng = np.random.default_rng(2)
    x = middle[:, None] + spread[:, None] * rng.standard_normal((plant.n, 7))
    return plant, step, x, 2 * rng.standard_normal((plant.m, 7))


@every_plant
def test_a_flow_converges_with_order_four_to_the_integrator_of_scipy(name):
    plant, step, x, u = case(name)
    exact = np.stack([solve_ivp(lambda t, z, k=k: plant.rhs(z[:, None], u[:, k:k + 1])[:, 0], (0, step), x[:, k], method="DOP853",
                                rtol=1e-13, atol=1e-15).y[:, -1] for k in range(x.shape[1])], axis=1)
    scale = np.abs(exact).max(axis=1, keepdims=True)
    errors = [np.abs((plant.flow(step, parts=parts)(x, u) - exact) / scale).max() for parts in (2, 4, 8, 40)]
    assert 11 < errors[0] / errors[1] < 24 and 11 < errors[1] / errors[2] < 24, errors  # 2⁴ = 16
    assert errors[3] < 2e-8


@every_plant
def test_slopes_by_hand_are_those_of_a_complex_step_and_of_finite_differences(name):
    plant, _, x, u = case(name)
    for value, slope in ((plant.rhs, plant.slope), (plant.output, plant.output_slope)):
        hand, (_, stepped) = slope(x, u), slopes(value, x, u)
        size = np.abs(stepped).max(axis=0) + 1e-300
        np.testing.assert_allclose(hand / size, stepped / size, atol=1e-12)
        for j in range(plant.n):
            h = 1e-6 * np.abs(x[j]).max()
            shift = np.zeros((plant.n, 1))
            shift[j] = h
            apart = ((value(x + shift, u) - value(x - shift, u)) / (2 * h)).T
            np.testing.assert_allclose(hand[:, :, j], apart, rtol=1e-5, atol=1e-6 * np.abs(hand[:, :, j]).max() + 1e-12)


@every_plant
def test_the_slope_of_a_flow_is_that_of_the_discrete_map(name):
    plant, step, x, u = case(name)
    flow = plant.flow(step, parts=3)
    later, Phi = flow.expand(x, u)
    np.testing.assert_allclose(later, flow(x, u), rtol=1e-15)
    by_step = slopes(flow, x, u)[1]
    size = np.abs(by_step).max(axis=0) + 1e-300
    np.testing.assert_allclose(Phi / size, by_step / size, atol=1e-11)
    np.testing.assert_allclose(Flow(plant.rhs, step, 3).expand(x, u)[1] / size, Phi / size, atol=1e-11)


def test_the_growth_model_is_expanded_rightly():
    x, u = np.linspace(-20, 20, 9)[None], np.array([[growth.drive(3)]])
    for value, expanded in ((growth.step, growth.step_expanded), (growth.seen, growth.seen_expanded)):
        np.testing.assert_allclose(expanded(x, u)[1], slopes(value, x, u)[1], rtol=1e-12)
        np.testing.assert_allclose(expanded(x, u)[0], value(x, u))
    assert growth.step(np.array([[2.0]]), np.array([[0.5]])).item() == pytest.approx(1 + 10 + 0.5)


def test_without_hardening_and_weakening_the_platform_is_the_linear_deck():
    bent, straight = nonlinear.plant(nonlinear.NonlinearLaws(0.0, 0.0)), model.deck()
    x, u = np.random.default_rng(0).standard_normal((2, 6, 5))
    np.testing.assert_allclose(bent.rhs(x, u[:3]), straight.A @ x + straight.B @ u[:3], rtol=1e-13)
    expanded = nonlinear.plant().linear(np.zeros(6), np.zeros(3))
    for ours, theirs in ((expanded.A, straight.A), (expanded.B, straight.B), (expanded.C, straight.C)):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12)


def test_a_spring_stretched_by_its_length_is_stiffer_by_the_hardening():
    laws = nonlinear.NonlinearLaws(0.7, 0.0, 0.004)
    plant, x = nonlinear.plant(laws), np.array([[0.0, 0.004, 0.0, 0.0, 0.0, 0.0]]).T
    k, rigid = model.Parameters(), model.rigid()
    pull = -2 * k.kz * 0.004 * 1.7
    assert plant.rhs(x, np.zeros((3, 1)))[4, 0] == pytest.approx(pull / rigid.M[1, 1], rel=1e-12)


def test_the_pendulum_expanded_about_upright_is_the_linear_one():
    for sensor in ("position", "angle", "both"):
        parameters = cart_pendulum.Parameters(pivot=0.02)
        expanded = cart_pendulum.nonlinear_plant(parameters, sensor).linear(np.zeros(4), [0.0])
        straight = cart_pendulum.plant(parameters, sensor)
        for ours, theirs in ((expanded.A, straight.A), (expanded.B, straight.B), (expanded.C, straight.C)):
            np.testing.assert_allclose(ours, theirs, atol=1e-13)


def test_the_pole_keeps_its_energy_without_friction():
    k = cart_pendulum.Parameters(friction=0.0)
    plant = cart_pendulum.nonlinear_plant(k)

    def energy(x):
        _, angle, v, omega = x
        ball = v**2 + 2 * k.length * v * omega * np.cos(angle) + (k.length * omega)**2
        return k.cart * v**2 / 2 + k.ball * ball / 2 + k.ball * k.g * k.length * np.cos(angle)

    x, flow = np.array([[0.0, 0.5, 0.3, 0.0]]).T, plant.flow(0.01, parts=2)
    before = energy(x)
    for _ in range(300):
        x = flow(x, np.zeros((1, 1)))
    assert energy(x) == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("call, sentence", [
    (lambda: Flow(lambda x, u: x, 0.0), "above 0"),
    (lambda: slopes(lambda x, u: np.abs(x), np.ones((2, 1)), np.zeros((0, 1))), "give its slope"),
    (lambda: slopes(lambda x, u: x[:, :1], np.ones((2, 3)), np.zeros((0, 1))), "a column for each"),
])
def test_bad_flows_get_one_sentence(call, sentence):
    with pytest.raises((EngineError, ShapeError), match=sentence):
        call()


def test_the_expansion_of_a_plant_keeps_its_direct_path():
    plant = NonlinearPlant(1, 1, 1, lambda x, u: -x**3 + u, lambda x, u: (-3 * x**2).T[:, :, None],
                           lambda x, u: x + u**2, lambda x, u: np.ones((x.shape[1], 1, 1)))
    found = plant.linear([2.0], [3.0])
    assert (found.A, found.B, found.C, found.D) == (-12.0, 1.0, 1.0, 6.0)
