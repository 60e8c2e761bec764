"""The named plants against physics, published numbers and the stage's own rules."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.signal import place_poles

from app.engine.errors import EngineError
from app.engine.placement import observer_gain, place
from app.plants import MODELS, chip, model, platform, spring_damper, two_mass
from app.plants import cart_pendulum as cart
from app.plants.body import Body, Spring, between, bounded
from app.plants.two_mass import HIDDEN, Parameters, hidden

EVERY = [*MODELS.values(), *(h.model for h in HIDDEN.values())]
every_model = pytest.mark.parametrize("m", EVERY, ids=lambda m: m.id)
PUBLISHED_HANKEL = [572.7760, 572.7760, 360.3035, 360.2847, 43.0561, 43.0313, 0.053902, 0.053898, 8.85e-5, 8.85e-5]
PUBLISHED_MODES = [(0.995, 0.59), (1.193, 0.47), (1.494, 0.58), (30.21, 2.53), (30.32, 2.54)]


def modes(plant) -> list[tuple[float, float]]:
    """(Hz, damping in %) of the complex pairs, slowest first."""
    return sorted((abs(p) / (2 * math.pi), -100 * p.real / abs(p)) for p in plant.poles if p.imag > 0)


def rank(matrix) -> int:
    return int(np.linalg.matrix_rank(matrix))


def pbh_seen(plant, pole) -> bool:
    return rank(np.vstack([plant.A - pole * np.eye(plant.n), plant.C])) == plant.n


def pbh_moved(plant, pole) -> bool:
    return rank(np.hstack([plant.A - pole * np.eye(plant.n), plant.B])) == plant.n


# --- the platform ---------------------------------------------------------------------------------------------------

def test_platform_has_the_published_hankel_singular_values():
    p = platform.plant()
    reach = solve_continuous_lyapunov(p.A, -p.B @ p.B.T)
    see = solve_continuous_lyapunov(p.A.T, -p.C.T @ p.C)
    values = np.sqrt(np.sort(np.abs(np.linalg.eigvals(reach @ see)))[::-1])
    np.testing.assert_allclose(values, PUBLISHED_HANKEL, rtol=2e-3)
    np.testing.assert_allclose(values[:6], PUBLISHED_HANKEL[:6], rtol=2e-6)


def test_platform_has_the_published_frequencies_and_dampings():
    np.testing.assert_allclose(modes(platform.plant()), PUBLISHED_MODES, rtol=5e-3, atol=5e-3)


def test_platform_first_hankel_value_is_the_closed_form_of_its_vertical_mode():
    frequency, damping = modes(platform.plant())[2]
    assert math.sqrt(2) * (2 * math.pi * frequency) / (4 * damping / 100) == pytest.approx(572.776, rel=1e-3)


def test_deck_keeps_the_three_slow_modes_of_the_platform():
    np.testing.assert_allclose(modes(platform.deck()), modes(platform.plant())[:3], rtol=5e-5)  # (ω/ω_p)² 2μ/m


def test_deck_is_the_limit_of_stiff_sensor_springs():
    p, d = platform.plant(platform.Parameters(kp=1.8e7, cp=480.0)), platform.deck()
    s = 1j * 2 * math.pi * np.array([0.3, 1.1, 2.0, 5.0])
    for point in s:
        full = p.C @ np.linalg.solve(point * np.eye(10) - p.A, p.B)
        rigid_B = np.hstack([d.B, platform.deck_disturbance()])
        reduced = d.C @ np.linalg.solve(point * np.eye(6) - d.A, rigid_B)
        np.testing.assert_allclose(full, reduced, rtol=1e-3, atol=1e-6 * np.abs(reduced).max())


def test_platform_outputs_are_in_the_order_VL_HL_VR_HR():
    k, p, d = platform.Parameters(), platform.plant(), platform.deck()
    rates = np.array([0.3, -0.2, 0.7])  # of x, z and θ
    expected = [-0.2 - k.s * 0.7, 0.3 + k.h * 0.7, -0.2 + k.s * 0.7, -(0.3 + k.h * 0.7)]
    np.testing.assert_allclose(d.C @ [0, 0, 0, *rates], expected)
    np.testing.assert_allclose(p.C @ [0, 0, 0, 0, 0, *rates, 0, 0], expected)
    assert p.output_names == d.output_names == ("VL", "HL", "VR", "HR")


def test_platform_loses_energy_only_in_its_dampers():
    mech, p = platform.mechanics(), platform.plant()
    rng = np.random.default_rng(1)
    for x in rng.normal(size=(5, 10)) * 1e-3:
        q, v = x[:5], x[5:]
        xdot = p.A @ x
        power = v @ mech.M @ xdot[5:] + q @ mech.K @ xdot[:5]
        np.testing.assert_allclose(power, -v @ mech.D @ v, rtol=1e-9, atol=1e-18)


def test_platform_potential_energy_is_the_sum_over_its_springs():
    k, K = platform.Parameters(), platform.mechanics().K
    x, z, angle, left, right = q = np.random.default_rng(2).normal(size=5)
    stretched = (k.kz * (z - k.a * angle) ** 2 + k.kz * (z + k.a * angle) ** 2 + k.kx * (x + k.h * angle) ** 2
                 + k.kp * (z - k.s * angle - left) ** 2 + k.kp * (z + k.s * angle - right) ** 2)
    assert q @ K @ q == pytest.approx(stretched, rel=1e-12)


def test_ground_motion_carries_the_deck_with_it():
    p = platform.plant()
    settled = np.linalg.solve(-p.A, p.B[:, 3:])
    np.testing.assert_allclose(settled[:, 0], [0, 1, 0, 1, 1, 0, 0, 0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(settled[0, 1] + platform.Parameters().h * settled[2, 1], 1, rtol=1e-9)


def test_platform_controller_drives_the_coils_and_not_the_ground():
    m = MODELS["platform"]
    assert m.controlled.input_names == ("u1", "u2", "u3")
    disturbed = m.disturbed
    assert disturbed is not None
    np.testing.assert_array_equal(np.hstack([m.controlled.B, disturbed]), m.plant.B)
    assert MODELS["deck"].controlled is MODELS["deck"].plant and MODELS["deck"].disturbed is None


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


# --- the two-mass chain ---------------------------------------------------------------------------------------------

def test_chain_loses_energy_only_in_its_dampers():
    k = Parameters(m1=1.5, m2=0.7, left=3.0, between=5.0, right=2.0, left_damping=0.2, between_damping=0.4,
                   right_damping=0.1)
    p = two_mass.plant(k)
    for q1, q2, v1, v2 in np.random.default_rng(5).normal(size=(5, 4)):
        a = p.A @ [q1, q2, v1, v2]
        power = (k.m1 * v1 * a[2] + k.m2 * v2 * a[3]
                 + k.left * q1 * v1 + k.right * q2 * v2 + k.between * (q2 - q1) * (v2 - v1))
        lost = k.left_damping * v1**2 + k.right_damping * v2**2 + k.between_damping * (v2 - v1) ** 2
        assert power == pytest.approx(-lost, rel=1e-10)


def test_default_chain_is_seen_and_moved_as_a_whole():
    p = two_mass.plant()
    assert all(pbh_seen(p, pole) and pbh_moved(p, pole) for pole in p.poles)


@pytest.mark.parametrize("h", HIDDEN.values(), ids=lambda h: h.case)
def test_hidden_motion_is_hidden_by_pbh_and_nothing_else_is(h):
    p = h.model.plant
    lost = [pole for pole in p.poles if not (pbh_seen if h.unseen else pbh_moved)(p, pole)]
    np.testing.assert_allclose(lost, h.poles, atol=1e-12)
    assert all((pbh_moved if h.unseen else pbh_seen)(p, pole) for pole in p.poles)
    assert h.stable == (max(pole.real for pole in h.poles) < 0)
    wanted = h.model.observer_poles if h.unseen else h.model.controller_poles
    assert set(h.poles) <= set(wanted)


@pytest.mark.parametrize("h", HIDDEN.values(), ids=lambda h: h.case)
def test_hidden_motion_leaves_no_trace_and_takes_no_push(h):
    p, start = h.model.plant, np.array(h.direction)
    for t in (0.5, 2.0, 5.0):
        moved = expm(p.A * t)
        if h.unseen:
            assert np.abs(p.C @ moved @ start).max() < 1e-10
        else:  # the force changes neither the common position nor the common velocity
            assert np.abs(np.array([[1, 1, 0, 0], [0, 0, 1, 1]]) @ moved @ p.B).max() < 1e-10


@pytest.mark.parametrize("h", HIDDEN.values(), ids=lambda h: h.case)
def test_hidden_motion_decides_the_fate_of_the_run_from_the_model_start(h):
    m, p = h.model, h.model.plant
    if h.unseen:
        fate, start = p.A - observer_gain(p.A, p.C, m.observer_poles).gain @ p.C, np.subtract(m.x0, m.guess)
    else:
        fate, start = p.A - p.B @ place(p.A, p.B, m.controller_poles).gain, np.array(m.x0)
    growth = np.linalg.norm(expm(fate * m.horizon) @ start) / np.linalg.norm(start)
    assert (growth < 0.3) if h.stable else (growth > 5)


def test_unmoved_chain_is_dual_to_the_unseen_one_in_the_pushed_and_measured_direction():
    for kind in ("stable", "unstable"):
        unseen, unmoved = HIDDEN[f"unseen-{kind}"].model.plant, HIDDEN[f"unmoved-{kind}"].model.plant
        np.testing.assert_array_equal(unseen.A, unmoved.A)
        for s in (0.3 + 1j, 2.0 - 0.7j):  # reciprocity: the transfer function is the same from either side
            resolvent = np.linalg.inv(s * np.eye(4) - unseen.A)
            np.testing.assert_allclose(unseen.C @ resolvent @ unseen.B, unmoved.C @ resolvent @ unmoved.B, rtol=1e-10)


def test_chain_that_does_not_fit_its_case_is_refused_in_one_sentence():
    with pytest.raises(EngineError, match="identical"):
        hidden("unseen-stable", Parameters())
    with pytest.raises(EngineError, match="do not fit the case"):
        hidden("unseen-stable", two_mass.DEPARTS)
    with pytest.raises(EngineError, match="no case"):
        hidden("unseen")  # type: ignore[arg-type]
    with pytest.raises(EngineError, match="no sensor"):
        two_mass.plant(sensor="third")  # type: ignore[arg-type]
    with pytest.raises(EngineError, match="no actuator"):
        two_mass.plant(actuator="third")  # type: ignore[arg-type]
    with pytest.raises(EngineError, match="no sensor"):
        cart.plant(sensor="smell")  # type: ignore[arg-type]


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
        assert text.en and text.zh and text.en != text.zh
        assert any("\u4e00" <= letter <= "\u9fff" for letter in text.zh)


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


# --- bodies ---------------------------------------------------------------------------------------------------------

def turned(wxyz, vector) -> np.ndarray:
    """The vector after the rotation, by Rodrigues' formula."""
    w, axis = wxyz[0], np.array(wxyz[1:])
    return np.asarray(vector) + 2 * w * np.cross(axis, vector) + 2 * np.cross(axis, np.cross(axis, vector))


def end(pose) -> np.ndarray:
    """Where a spring or rod ends."""
    return np.array(pose.position) + turned(pose.wxyz, (0, 0, pose.scale[2]))


def states(m) -> list[list[float]]:
    n = m.plant.n
    signs = [(-1.0) ** i for i in range(n)]
    return [[0.0] * n, list(m.x0), list(m.kick), [1e6] * n, [1e6 * s for s in signs], [-1e300 * s for s in signs]]


@every_model
def test_body_poses_every_part_with_finite_numbers_and_unit_quaternions(m):
    body: Body = m.body
    for x in states(m):
        poses = body.pose(x, body.gain)
        assert set(poses) == {part.name for part in body.parts} and len(poses) == len(body.parts)
        for pose in poses.values():
            assert np.all(np.isfinite([*pose.position, *pose.scale])) and min(pose.scale) > 0
            assert math.hypot(*pose.wxyz) == pytest.approx(1, abs=1e-12)
            assert pose.colour is None or all(0 <= c <= 255 and isinstance(c, int) for c in pose.colour)


@every_model
def test_body_never_leaves_the_stage_when_a_run_diverges(m):
    body: Body = m.body
    stretched = {part.name for part in body.parts if isinstance(part.shape, Spring)}
    for x in states(m):
        poses = body.pose(x, body.gain)
        points = [pose.position for pose in poses.values()] + [tuple(end(poses[name])) for name in stretched]
        points += body.anchors(x, body.gain)
        points += [a.head for a in body.arrows(x, [1e9] * m.plant.m, body.gain)]
        for right, away, up in points:
            assert abs(right) < 3.0 and abs(away) < 1.5 and 0 <= up < 3.2


@every_model
def test_ghost_vanishes_into_the_body_when_the_estimate_is_right(m):
    body: Body = m.body
    ghost = [part.name for part in body.parts if part.twin]
    assert ghost
    rest, start = body.pose([0.0] * m.plant.n, body.gain), body.pose(list(m.x0), body.gain)
    assert any(math.dist(rest[name].position, start[name].position) > 0.02 for name in ghost)
    assert body.anchors(list(m.x0), body.gain) == body.anchors(tuple(np.array(m.x0)), body.gain)
    assert len(body.anchors(list(m.x0), body.gain)) == len(body.anchors(list(m.guess), body.gain)) >= 2


@every_model
def test_each_input_has_an_arrow_that_turns_with_its_sign(m):
    for i in range(m.plant.m):
        u = [0.0] * m.plant.m
        lengths = []
        for value in (0.0, 0.3 * m.u_max, -0.3 * m.u_max):
            u[i] = value
            arrows = m.body.arrows(list(m.x0), u, m.body.gain)
            lengths.append(np.sum([np.subtract(a.head, a.tail) * k for k, a in enumerate(arrows, 1)], axis=0))
        assert np.all(lengths[0] == 0) and np.abs(lengths[1]).max() > 0.05
        np.testing.assert_allclose(lengths[1], -lengths[2], atol=1e-12)


def test_positive_pitch_lifts_the_right_side_of_the_deck():
    left, _, right, _ = MODELS["deck"].body.anchors([0, 0, 0.005, 0, 0, 0], 20.0)
    assert right[2] > left[2] + 0.1


def test_deck_motion_of_two_millimetres_is_drawn_as_three_tenths():
    body = MODELS["deck"].body
    rise = body.pose([0, 0.0005, 0, 0, 0, 0], body.gain)["deck"].position[2] - body.pose([0] * 6, body.gain)[
        "deck"].position[2]
    assert 4 * rise == pytest.approx(0.3, rel=0.02)


@pytest.mark.parametrize("id", ["deck", "platform"])
def test_deck_springs_stay_fastened_to_the_deck(id):
    body, n = MODELS[id].body, MODELS[id].plant.n
    fastened = []
    for x in ([0.0] * n, [0.002, -0.001, 0.01, *[0.0] * (n - 3)], [-1.0, 1.0, -1.0, *[0.0] * (n - 3)]):
        poses = body.pose(x, body.gain)
        deck = poses["deck"]
        back = (deck.wxyz[0], *(-c for c in deck.wxyz[1:]))
        fastened.append([turned(back, end(poses[name]) - np.array(deck.position))
                         for name in ("spring left", "spring right", "spring across", "rod left", "rod right")])
    np.testing.assert_allclose(fastened[1], fastened[0], atol=1e-9)
    np.testing.assert_allclose(fastened[2], fastened[0], atol=1e-9)


def test_test_masses_of_the_platform_move_against_each_other_on_the_stage():
    body = MODELS["platform"].body
    rest = body.pose([0.0] * 10, body.gain)
    apart = body.pose([0, 0, 0, 5e-4, -5e-4, 0, 0, 0, 0, 0], body.gain)
    for side, up in (("left", 1), ("right", -1)):
        rise = apart[f"test mass {side}"].position[2] - rest[f"test mass {side}"].position[2]
        assert rise * up > 0.04
    assert apart["deck"] == rest["deck"]


def test_pole_leans_to_the_right_for_a_positive_angle():
    body = MODELS["cart-pendulum"].body
    poses = body.pose([0.0, 0.3, 0.0, 0.0], 1.0)
    assert poses["ball"].position[0] > poses["cart"].position[0] + 0.3
    np.testing.assert_allclose(end(poses["pole"]), poses["ball"].position, atol=1e-12)


def test_hotter_chip_stands_higher_and_glows_redder():
    body = MODELS["chip"].body
    cold, hot = body.pose([0.0, 0.0], 1.0), body.pose([40.0, 10.0], 1.0)
    assert hot["core level"].position[2] > hot["case level"].position[2] > cold["case level"].position[2]
    die, air = hot["die"].colour, cold["die"].colour
    assert die is not None and air is not None and die[0] - die[2] > air[0] - air[2] + 50


coordinate = st.floats(-5, 5)
point = st.tuples(coordinate, coordinate, coordinate)


@given(point, point)
def test_a_spring_reaches_exactly_from_one_point_to_the_other(start, finish):
    pose = between(start, finish)
    np.testing.assert_allclose(end(pose), finish, atol=2e-6)
    assert math.hypot(*pose.wxyz) == pytest.approx(1, abs=1e-12)


@given(st.floats(allow_nan=False), st.floats(1e-3, 10))
def test_bounded_motion_stays_within_its_limit_and_keeps_its_sign(value, limit):
    drawn = bounded(value, limit)
    assert abs(drawn) <= limit * (1 + 1e-12)
    assert drawn * value >= 0
    if abs(value) < 0.01 * limit:
        assert drawn == pytest.approx(value, rel=1e-3, abs=1e-300)
