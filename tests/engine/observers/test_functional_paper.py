"""The two examples of the robust observer paper: printed matrices, criteria and figures, and its slips."""

import numpy as np
import pytest
from paper_examples import ONE, TWO, one, two
from scipy.integrate import solve_ivp

from observer_lab.engine import EngineError, functional_observer, simulate_functional
from observer_lab.engine.observers import error_index, error_transfer, perturbed_loop, vertices, worst_error_gain
from observer_lab.plants.duan import EXAMPLE_1, EXAMPLE_2, outer_input


# --- example 1 -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("s", [-0.5, -5 / 3, -5, -10])
def test_example_1_is_as_printed_for_every_s(s):
    o = one(s)
    np.testing.assert_allclose(o.F, [[s]], rtol=1e-15)
    np.testing.assert_allclose(o.T, [[1, s]], rtol=1e-14)
    np.testing.assert_allclose(o.L, [[-s * s - 4 * s - 3]], rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(o.N, [[-30]], rtol=1e-13)
    np.testing.assert_allclose(o.M, [[50 + 30 * s]], rtol=1e-12, atol=1e-12)
    house = functional_observer(ONE, EXAMPLE_1.K, 1, poles=[s])  # u = −K x: N, M change sign, F, T, L do not
    for mine, theirs in ((house.F, o.F), (house.T, o.T), (house.L, o.L), (-house.N, o.N), (-house.M, o.M)):
        np.testing.assert_allclose(mine, theirs, atol=1e-12)


@pytest.mark.parametrize("norm", [1, 2, "inf"])
@pytest.mark.parametrize(("s", "J"), [(-5 / 3, 38 / 9), (-1, 22), (-3, 46), (-5, 118), (-10, 333)])
def test_example_1_criterion(norm, s, J):
    assert pytest.approx(J, rel=1e-12) == one(s, norm=norm).J


def test_example_1_state_feedback_poles():
    poles = np.sort_complex(np.linalg.eigvals(ONE.A + ONE.B @ EXAMPLE_1.K_printed))
    np.testing.assert_allclose(poles, [-7 - 2j, -7 + 2j])


@pytest.mark.parametrize(("s", "true", "perturbed"), [(-5 / 3, -11, None), (-5, -111, -116)])
def test_figure_1_starts(s, true, perturbed):
    o = functional_observer(ONE, EXAMPLE_1.K, 1, poles=[s])
    run = simulate_functional(o, outer_input, x0=EXAMPLE_1.x0, z0=EXAMPLE_1.z0)
    assert run.e_u[0, 0] == pytest.approx(true, abs=1e-11)
    np.testing.assert_allclose(run.e_u[:, 0], true * np.exp(s * run.t), atol=1e-10)  # the true plant: N ε alone
    if perturbed:
        wrong = simulate_functional(o, outer_input, x0=EXAMPLE_1.x0, z0=EXAMPLE_1.z0, dA=EXAMPLE_1.dA, dC=EXAMPLE_1.dC)
        assert wrong.e_u[0, 0] == pytest.approx(perturbed, abs=1e-11)


@pytest.mark.parametrize(("s", "amplitude", "poles"), [
    (-5 / 3, 0.431366, [-7.1676 - 2.5373j, -7.1676 + 2.5373j, -1.7315]),
    (-5, 0.941342, [-17.9748, -3.2126 - 2.7363j, -3.2126 + 2.7363j]),
])
def test_figure_1_perturbed_poles_and_steady_amplitude(s, amplitude, poles):
    o = functional_observer(ONE, EXAMPLE_1.K, 1, poles=[s])
    loop = perturbed_loop(o, dA=EXAMPLE_1.dA, dB=None, dC=EXAMPLE_1.dC)
    np.testing.assert_allclose(loop.poles, poles, atol=6e-5)
    run = simulate_functional(o, outer_input, x0=EXAMPLE_1.x0, z0=EXAMPLE_1.z0, horizon=20.0, dA=EXAMPLE_1.dA, dC=EXAMPLE_1.dC)
    late = run.t > 15
    wave = np.column_stack([np.sin(5 * run.t[late]), np.cos(5 * run.t[late])])
    fitted = np.hypot(*np.linalg.lstsq(wave, run.e_u[late, 0], rcond=None)[0])
    assert fitted == pytest.approx(amplitude, abs=6e-7)


def test_run_against_an_adaptive_solver_written_from_the_paper():
    """u = N z + M y + v in the source's sign, integrated step by step: the same x."""
    s, dA, dC = -5.0, EXAMPLE_1.dA, EXAMPLE_1.dC

    def rate(t, w):
        y = ((ONE.C + dC) @ w[:2]).item()
        u = -30 * w[2] + (50 + 30 * s) * y - 4 * np.sin(5 * t + np.pi / 2)
        dx = (ONE.A + dA) @ w[:2] + ONE.B[:, 0] * u
        return [*dx, s * w[2] - (s * s + 4 * s + 3) * y + (2 + s) * u]

    peer = solve_ivp(rate, (0, 4), [1, 1, -0.3], "DOP853", [1, 2, 4], rtol=1e-12, atol=1e-13).y.T
    o = functional_observer(ONE, EXAMPLE_1.K, 1, poles=[s])
    run = simulate_functional(o, outer_input, x0=EXAMPLE_1.x0, z0=EXAMPLE_1.z0, horizon=4.0, dA=dA, dC=dC)
    np.testing.assert_allclose(np.hstack([run.x, run.z])[[100, 200, 400]], peer, atol=1e-9)
    v_less = run.u - run.v
    np.testing.assert_allclose(v_less[:, 0], -30 * run.z[:, 0] + (50 + 30 * s) * run.y[:, 0], atol=1e-9)


def grid_worst(s):
    """Worst |e_u/v| over the eight sign vertices, by brute force on a dense frequency grid."""
    N, M, L = -30.0, 50 + 30 * s, -(s * s + 4 * s + 3)
    worst = 0.0
    omega = np.concatenate([[0.0], np.geomspace(1e-2, 1e3, 4000)])
    for a1 in (0.1, -0.1):
        for a2 in (0.4, -0.4):
            for c in (0.05, -0.05):
                A, C = np.array([[0, -3], [1 + a1, -4 + a2]]), np.array([0, 1 + c])
                B, TB = np.array([2.0, 1.0]), 2 + s
                whole = np.block([[A + np.outer(B, M * C), (N * B)[:, None]], [(L + TB * M) * C, s + TB * N]])
                into, out = np.append(B, TB), np.append(M * C - [-30, 50], N)
                solved = np.linalg.solve(1j * omega[:, None, None] * np.eye(3) - whole, into[None, :, None] + 0j)
                worst = max(worst, np.abs(out @ solved[:, :, 0].T).max())
    return worst


@pytest.mark.parametrize(("s", "value"), [(-1.30, 0.820), (-5 / 3, 0.874)])
def test_worst_of_the_eight_vertices(s, value):
    o = functional_observer(ONE, EXAMPLE_1.K, 1, poles=[s])
    worst = worst_error_gain(o, vertices(EXAMPLE_1.wrong, EXAMPLE_1.delta_A, EXAMPLE_1.delta_C))
    assert worst == pytest.approx(value, abs=6e-4)
    assert worst == pytest.approx(grid_worst(s), rel=1e-4)


def test_worst_vertex_at_minus_5_by_brute_force():
    o = functional_observer(ONE, EXAMPLE_1.K, 1, poles=[-5])
    worst = worst_error_gain(o, vertices(EXAMPLE_1.wrong, EXAMPLE_1.delta_A, EXAMPLE_1.delta_C))
    assert worst == pytest.approx(grid_worst(-5.0), rel=1e-4)


# --- example 2 -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("W", [None, EXAMPLE_2.turn])
@pytest.mark.parametrize(("s1", "s2"), [(-4, -2), (-1.5, -2.5), (-0.3, -7)])
def test_example_2_is_as_printed(s1, s2, W):
    o = two(s1, s2, W=W)
    turn, back = (np.eye(2), np.eye(2)) if W is None else (W, np.linalg.inv(W))
    k0, k1, k2, a1, a2 = -4, -4, -1, 2, 3
    np.testing.assert_allclose(o.F, turn @ np.diag([s1, s2]) @ back, atol=1e-12)
    np.testing.assert_allclose(o.T, turn @ [[s * s + a2 * s + a1, s + a2, 1] for s in (s1, s2)], atol=1e-12)
    np.testing.assert_allclose(o.L, turn @ [[-s * (s + 1) * (s + 2)] for s in (s1, s2)], atol=1e-11)
    printed = np.array([[k2 * (s2 + a2) - k1, k1 - k2 * (s1 + a2)]]) / (s2 - s1)
    np.testing.assert_allclose(o.N, printed @ back, atol=1e-11)
    np.testing.assert_allclose(o.M, [[k0 - k1 * (s1 + s2 + a2) + k2 * ((s1 + a2) * (s2 + a2) - a1)]], atol=1e-11)
    np.testing.assert_allclose(o.M, [[1 + s1 + s2 - s1 * s2]], atol=1e-11)


def test_example_2_poles():
    np.testing.assert_allclose(TWO.poles, [-2, -1, 0], atol=1e-12)
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(TWO.A + TWO.B @ EXAMPLE_2.K_printed)),
                               [-2, -1 - 1j, -1 + 1j], atol=1e-12)


def test_example_2_equal_poles_are_refused():
    with pytest.raises(EngineError, match="move the poles"):
        two(-3, -3)


def test_W_changes_coordinates_and_nothing_that_can_be_felt():
    """The contrast of figure 2 comes from starting both at the same z(0)."""
    E, omega = EXAMPLE_2, np.geomspace(0.01, 100, 40)
    plain, turned = (functional_observer(TWO, E.K, 2, poles=[-4, -3], W=W, wrong=E.wrong) for W in (None, E.turn))
    loops = [perturbed_loop(o, dA=E.dA, dB=None, dC=E.dC) for o in (plain, turned)]
    np.testing.assert_allclose(loops[0].poles, loops[1].poles, atol=1e-9)
    np.testing.assert_allclose(error_transfer(plain, omega, dA=E.dA, dC=E.dC),
                               error_transfer(turned, omega, dA=E.dA, dC=E.dC),
                               rtol=1e-9)
    assert error_index(plain) == pytest.approx(error_index(turned), rel=1e-9)
    assert abs(plain.J - turned.J) > 1  # J does see W
    same = [simulate_functional(o, outer_input, x0=E.x0, z0=E.z0) for o in (plain, turned)]
    moved = simulate_functional(turned, outer_input, x0=E.x0, z0=E.turn @ np.array(E.z0))
    assert np.abs(same[0].e_u - same[1].e_u).max() > 1
    np.testing.assert_allclose(moved.e_u, same[0].e_u, atol=1e-10)


# --- slips of the paper --------------------------------------------------------------------------------------------
def test_remark_3_needs_the_inverse_and_T():
    """Printed (F, ΛF, ΛL, NΛ⁻¹, M); right (ΛFΛ⁻¹, ΛT, ΛL, NΛ⁻¹, M)."""
    o, turn = two(-4, -3), np.array([[2.0, 1.0], [0.5, -1.0]])
    F, T, L = turn @ o.F @ np.linalg.inv(turn), turn @ o.T, turn @ o.L
    np.testing.assert_allclose(T @ TWO.A - F @ T, L @ TWO.C, atol=1e-11)
    np.testing.assert_allclose(o.N @ np.linalg.inv(turn) @ T + o.M @ TWO.C, o.K, atol=1e-11)
    printed = o.F @ T  # F left as it is
    assert np.abs(T @ TWO.A - printed - L @ TWO.C).max() > 0.1
    assert (turn @ o.F).shape != o.T.shape  # ΛF cannot stand where T belongs


def test_L_delta_C_has_three_columns():
    assert (two(-4, -3).L @ EXAMPLE_2.dC).shape == (2, 3)
