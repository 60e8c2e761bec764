"""Small plants against their own physics, and every model against its own numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plant_models import every_model, pbh_seen, rank
from scipy.linalg import expm
from scipy.signal import place_poles

from observer_lab.engine import EngineError, observer_gain, place
from observer_lab.engine.systems import as_matrix
from observer_lab.plants import MODELS, chip, model, spring_damper
from observer_lab.plants import cart_pendulum as cart


# --- the spring-damper ----------------------------------------------------------------------------------------------
def test_spring_damper_has_the_matrices_of_the_notes():
    p = spring_damper.plant()
    np.testing.assert_array_equal(p.A, [[0, 1], [-1, -0.5]])
    np.testing.assert_array_equal(p.B, [[0], [1]])
    np.testing.assert_array_equal(p.C, [[1, 0]])


def test_spring_damper_gain_for_two_poles_at_minus_one_is_that_of_the_corrected_notes():
    p = spring_damper.plant()
    closed = p.A - np.array([[1.5], [-0.75]]) @ p.C
    np.testing.assert_allclose(closed, [[-1.5, 1], [-0.25, -0.5]])
    np.testing.assert_allclose(np.poly(closed), [1, 2, 1], atol=1e-12)


def test_spring_damper_parameters_are_physical():
    p = spring_damper.plant(spring_damper.Parameters(m=2.0, b=0.6, k=8.0))
    np.testing.assert_allclose(np.poly(p.A), [1, 0.3, 4.0], rtol=1e-12)
    np.testing.assert_allclose(np.linalg.solve(-p.A, p.B)[0], 1 / 8)


# --- the chip -------------------------------------------------------------------------------------------------------
def test_chip_settles_where_the_heat_resistances_say():
    k, p = chip.Parameters(), chip.plant()
    np.testing.assert_allclose(np.linalg.solve(-p.A, p.B)[:, 0], [k.inner + k.outer, k.outer], rtol=1e-12)


def test_chip_heat_leaves_only_through_the_case():
    k, p = chip.Parameters(), chip.plant()
    for core, case in ((45.0, 20.0), (-3.0, 8.0)):
        rates = p.A @ [core, case]
        assert k.core * rates[0] + k.case * rates[1] == pytest.approx(-case / k.outer)


def test_chip_runs_away_exactly_above_the_critical_leakage():
    critical = chip.runaway_leakage()
    assert abs(np.linalg.det(chip.plant(leakage=critical).A)) < 1e-15
    assert max(chip.plant(leakage=0.99 * critical).poles.real) < 0 < max(chip.plant(leakage=1.01 * critical).poles.real)


def test_open_loop_copy_never_recovers_on_the_runaway_chip_and_does_on_the_plain_one():
    for id, recovers in (("chip", True), ("chip-runaway", False)):
        m = MODELS[id]
        e0 = np.subtract(m.x0, m.guess)
        error = np.linalg.norm(expm(m.plant.A * m.horizon) @ e0) / np.linalg.norm(e0)
        assert (error < 0.5) if recovers else (error > 2.0)


# --- the cart-pendulum ----------------------------------------------------------------------------------------------
DAMPED = cart.Parameters(cart=1.3, ball=0.4, length=0.7, friction=0.3, pivot=0.05)


@pytest.mark.parametrize("k", [cart.Parameters(), DAMPED], ids=["default", "damped"])
def test_cart_pendulum_matrices_are_the_complex_step_derivative_of_the_full_equations(k):
    p, step = cart.plant(k), 1e-30
    A = np.column_stack([cart.nonlinear(1j * step * row, 0.0, k).imag / step for row in np.eye(4)])
    B = cart.nonlinear(np.zeros(4), 1j * step, k).imag / step  # type: ignore[arg-type]
    np.testing.assert_allclose(p.A, A, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(p.B[:, 0], B, rtol=1e-12, atol=1e-14)


@given(st.floats(-3, 3), st.floats(-2, 2), st.floats(-6, 6), st.floats(-10, 10))
def test_cart_pendulum_energy_changes_by_the_force_and_the_friction_only(angle, v, omega, u):
    k = DAMPED

    def energy(x):
        ball_x = x[2] + k.length * np.cos(x[1]) * x[3]
        ball_z = -k.length * np.sin(x[1]) * x[3]
        return (k.cart * x[2] ** 2 / 2 + k.ball * (ball_x**2 + ball_z**2) / 2
                + k.ball * k.g * k.length * np.cos(x[1]))

    x = np.array([0.0, angle, v, omega])
    rate = cart.nonlinear(x, u, k)
    power = energy(x + 1e-30j * rate).imag / 1e-30
    expected = u * v - k.friction * v**2 - k.pivot * omega**2
    assert power == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_cart_pendulum_equations_take_whole_batches():
    x = np.random.default_rng(3).normal(size=(5, 7, 4))
    u = np.random.default_rng(4).normal(size=(5, 7))
    batch = cart.nonlinear(x, u)
    np.testing.assert_array_equal(batch[2, 3], cart.nonlinear(x[2, 3], u[2, 3]))
    assert batch.shape == x.shape


def test_position_sees_the_whole_cart_pendulum_and_angle_never_sees_where_the_cart_stands():
    for sensor, seen in (("position", True), ("angle", False), ("both", True)):
        p = cart.plant(sensor=sensor)
        assert pbh_seen(p, 0.0) is seen
        assert all(pbh_seen(p, pole) for pole in p.poles if abs(pole) > 1e-3)


# --- every model ----------------------------------------------------------------------------------------------------
def test_unknown_plant_is_refused_naming_the_known_ones():
    with pytest.raises(EngineError, match="spring-damper"):
        model("sputnik")
    assert model("deck") is MODELS["deck"]
    assert set(MODELS) == {"chip", "chip-runaway", "spring-damper", "cart-pendulum", "two-mass", "deck", "platform"}


@every_model
def test_model_numbers_fit_its_plant(m):
    n = m.plant.n
    assert len(m.x0) == len(m.guess) == len(m.kick) == n
    for poles, window in ((m.controller_poles, m.controller_window), (m.observer_poles, m.observer_window)):
        assert len(poles) == n
        np.testing.assert_allclose(np.sort_complex(poles), np.sort_complex(np.conj(poles)), atol=1e-12)
        assert window.re_low < 0 < window.re_high and window.im_high > 0
        for pole in (*poles, *m.plant.poles):  # the test masses ring far outside every useful window
            assert abs(pole) > 100 or (window.re_low < pole.real < window.re_high and abs(pole.imag) < window.im_high)
    assert all(len(s.weights) == n for s in m.watched)
    assert m.u_max > 0 and 300 <= m.horizon / m.dt <= 1000
    assert all(m.plant.unit(name) for name in
               (*m.plant.state_names, *m.plant.input_names, *m.plant.output_names))


@every_model
def test_model_reads_in_both_languages(m):
    for text in (m.label, m.body.caption, *(s.name for s in m.watched)):
        assert text("en") and text("zh") and text("en") != text("zh")
        assert any("\u4e00" <= letter <= "\u9fff" for letter in text("zh"))


@every_model
def test_model_poles_are_reached_by_the_engine(m):
    p = m.controlled
    for placement in (place(p.A, p.B, m.controller_poles), observer_gain(p.A, p.C, m.observer_poles)):
        assert placement.error < 1e-8


def run(m) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, e, u of the model's own start under its own poles, gains by SciPy."""
    p = m.controlled
    C = p.C[:rank(p.C)]
    K = place_poles(p.A, p.B, np.array(m.controller_poles), rtol=1e-2, maxiter=100).gain_matrix
    L = place_poles(p.A.T, C.T, np.array(m.observer_poles), rtol=1e-2, maxiter=100).gain_matrix.T
    step = expm(np.block([[p.A - p.B @ K, p.B @ K], [np.zeros_like(p.A), p.A - L @ C]]) * m.dt)
    z = [np.concatenate([m.x0, np.subtract(m.x0, m.guess)])]
    for _ in range(round(m.horizon / m.dt)):
        z.append(step @ z[-1])
    trajectory = np.array(z)
    x, e = trajectory[:, :p.n], trajectory[:, p.n:]
    return x, e, -(x - e) @ K.T


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Convergence was not reached")
@pytest.mark.parametrize("m", MODELS.values(), ids=lambda m: m.id)
def test_model_estimate_converges_in_view_with_natural_inputs(m):
    x, e, u = run(m)
    for signal in m.watched[:2]:
        assert abs(signal.of(e)[-1]) < 0.01 * np.abs(signal.of(x)).max()
    telling = np.abs(m.watched[0].of(e))
    assert telling[len(telling) // 40:].max() > 0.1 * telling[0]  # it takes its time, so that it can be watched
    assert m.u_max / 20 < np.abs(u).max() <= m.u_max
    apart = max(math.dist(a, b) for a, b in zip(
        m.body.anchors(list(m.x0), m.body.gain), m.body.anchors(list(m.guess), m.body.gain), strict=True))
    assert 0.1 < apart < 1.0  # stage units: the ghost starts off visibly


def test_imaginary_parts_of_a_matrix_are_not_dropped_in_silence():
    """NumPy drops them with a warning; the gain of a complex K was that of its real part."""
    with pytest.raises(EngineError, match="K has imaginary parts"):
        as_matrix(np.array([[1 + 2j]]), "K")
    assert as_matrix(np.array([[1 + 0j]]), "K").dtype == float
