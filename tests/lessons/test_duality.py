"""Duality: what is worked out on the observer's side must equal the controller of the transposed plant."""

from __future__ import annotations

import numpy as np
import pytest
from lesson_checks import by_knobs
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_continuous_are

from observer_lab.lessons.duality.dual_quantities import filter_riccati, gap, observer_by_polynomial, output_energy, run_pair
from observer_lab.lessons.duality.figures import locus, ratios
from observer_lab.lessons.duality.finite_horizon import horizon_of
from observer_lab.lessons.duality.knobs import MODEL
from observer_lab.lessons.duality.lesson import LESSON
from observer_lab.lessons.duality.study import turned
from observer_lab.text import label_in_language


def outcome(**changes):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


POLE_SETS = [(-1, -1), (-5, 1.5), (-0.8 - 0.8j, -0.8 + 0.8j), (-5 - 3j, -5 + 3j), (-3j, 3j)]


@pytest.mark.parametrize("poles", POLE_SETS)
@pytest.mark.parametrize("sensor", [0.0, 37.0, 90.0])
def test_observer_gain_is_the_transposed_feedback_of_the_transposed_plant(sensor, poles):
    o = outcome(sensor=sensor, poles=poles)
    np.testing.assert_allclose(o.gains["K_dual"].T, o.study.L, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(o.gains["L"], o.study.L, rtol=1e-11, atol=1e-13)
    p = turned(sensor)
    np.testing.assert_allclose(np.poly(p.A - o.study.L @ p.C), np.real(np.poly(poles)), atol=1e-10)


def test_published_gain_of_the_spring_damper_without_the_slip():
    o = outcome(poles=(-1, -1))
    np.testing.assert_allclose(o.study.L, [[1.5], [-0.75]], atol=1e-12)
    np.testing.assert_allclose(o.gains["K_dual"], [[1.5, -0.75]], atol=1e-12)


@pytest.mark.parametrize("sensor", [0.0, 37.0, 90.0])
@pytest.mark.parametrize("w, v", [(1.0, 1.0), (1e3, 1e-3), (1e-3, 1e3)])
def test_riccati_solutions_are_equal_under_the_swap(sensor, w, v):
    o = outcome(method="weights", mirror=False, sensor=sensor, w=w, v=v)
    np.testing.assert_allclose(o.study.S_dual, o.study.P, rtol=1e-8, atol=1e-10 * np.abs(o.study.P).max())
    p = turned(sensor)
    peer = solve_continuous_are(p.A.T, p.C.T, w * np.eye(2), [[v]])
    np.testing.assert_allclose(o.study.P, peer, rtol=1e-7, atol=1e-9 * np.abs(peer).max())
    np.testing.assert_allclose(o.gains["L"], peer @ p.C.T / v, rtol=1e-7, atol=1e-9 * np.abs(peer).max() / v)


def test_filter_solution_is_what_the_covariance_settles_at():
    p, W, V = turned(20.0), np.diag([0.5, 2.0]), np.array([[0.3]])

    def rate(_, flat):
        P = flat.reshape(2, 2)
        return (p.A @ P + P @ p.A.T - P @ p.C.T @ p.C @ P / V[0, 0] + W).ravel()
    settled = solve_ivp(rate, (0, 40), np.zeros(4), rtol=1e-10, atol=1e-12).y[:, -1].reshape(2, 2)
    np.testing.assert_allclose(filter_riccati(p.A, p.C, W, V), settled, atol=1e-7)


@pytest.mark.parametrize("window", [0.5, 4.0, 12.0])
def test_energy_heard_is_the_gramian_reached_by_the_twin(window):
    o = outcome(sensor=30.0, window=window)
    np.testing.assert_allclose(o.study.energies.seen, o.study.energies.seen_twin, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(o.study.energies.reach, o.study.energies.reach_twin, rtol=1e-11, atol=1e-13)


def test_output_energy_of_a_scalar_decay():
    energy = output_energy(np.array([[-2.0]]), np.array([[3.0]]), 1.5)
    assert energy[0, 0] == pytest.approx(9 / 4 * (1 - np.exp(-6.0)), rel=1e-13)


def test_pairing_of_observer_and_dual_loop_is_constant():
    for poles in POLE_SETS:
        o = outcome(poles=poles, sensor=15.0)
        assert abs(o.study.pairing[0]) > 0
        assert o.metrics["pairing_gap"] < 1e-10
        assert o.study.pairing[0] == pytest.approx(float(o.study.pair.z[0] @ o.study.pair.e[0]), rel=1e-12)


def test_a_wrong_gain_is_found_out():
    """The proof is no tautology: with a gain that is not the twin's, gap and pairing both show it."""
    p = turned(0.0)
    L = observer_by_polynomial(p.A, p.C, (-1, -2))
    _, e, z = run_pair(MODEL, p, L, L.T * 1.1)
    product = np.sum(e * z, axis=1)
    assert np.ptp(product) > 1e-3
    assert gap(L * 1.1, L) > 0.09


def test_velocity_sensor_mirrors_the_ellipses():
    assert outcome(sensor=90.0).metrics["mirror_gap"] < 1e-12
    assert outcome(sensor=80.0).metrics["mirror_gap"] > 0.02


def test_both_boards_are_moved_by_one_knob():
    boards = outcome(poles=(-2 - 1j, -2 + 1j)).boards
    assert [b.knob for b in boards] == ["poles", "poles"]
    assert boards[0].poles == boards[1].poles == (-2 - 1j, -2 + 1j)


def test_tasks_fail_at_the_start_and_pass_at_their_solution():
    for task in by_knobs(LESSON.tasks):
        assert not task.check(outcome()).solved, task.id
        assert task.check(outcome(**task.solution)).solved, task.id


def test_a_gain_task_judges_the_gain() -> None:
    """Whatever weights give the L of mirrored weights solve it; others do not."""
    task = next(t for t in LESSON.tasks if t.id == "ratio")
    for sensor in (0.0, 45.0, 90.0):
        for q, r in ((4.0, 1.0), (1.0, 1.0), (4.0, 4.0)):
            base = {"method": "weights", "mirror": False, "sensor": sensor, "q": q, "r": r}
            right, wrong = (LESSON.compute(LESSON.apply(LESSON.start(), {**base, "w": 40 * q, "v": v})) for v in (40 * r, 4 * r))
            assert task.check(right).solved and not task.check(wrong).solved


@pytest.mark.parametrize("window", [0.5, 4.0, 12.0])
def test_the_riccati_equations_in_time_are_those_of_an_integrator_and_settle_on_the_algebraic_ones(window: float) -> None:
    o = outcome(sensor=37.0, window=window, q=2.0, mirror=False, w=3.0, v=0.5)
    p, found = turned(37.0), o.study.horizon
    Q, R, W, V = 2.0 * np.eye(2), np.eye(1), 3.0 * np.eye(2), 0.5 * np.eye(1)

    def path(A, B, weight, price):
        def slope(_, flat):
            S = flat.reshape(2, 2)
            return (A.T @ S + S @ A - S @ B @ np.linalg.solve(price, B.T @ S) + weight).ravel()
        return solve_ivp(slope, (0, window), np.zeros(4), t_eval=found.t, rtol=1e-10, atol=1e-12).y.T.reshape(-1, 2, 2)
    np.testing.assert_allclose(found.S[::-1], path(p.A, p.B, Q, R), rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(found.P, path(p.A.T, p.C.T, W, V), rtol=1e-6, atol=1e-8)
    assert np.abs(found.S[-1]).max() == np.abs(found.P[0]).max() == 0 == np.abs(found.K[-1]).max()
    if window == 12.0:
        np.testing.assert_allclose(found.S[0], solve_continuous_are(p.A, p.B, Q, R), rtol=1e-5)
        np.testing.assert_allclose(found.P[-1], o.study.P, rtol=1e-5)


def integrated(A, G, Q, first, times):
    """X(τ) of dX/dτ = AᵀX + XA − XGX + Q by scipy's integrator."""
    n = len(A)

    def slope(_, flat):
        X = flat.reshape(n, n)
        return (A.T @ X + X @ A - X @ G @ X + Q).ravel()
    return solve_ivp(slope, (0, times[-1]), first.ravel(), t_eval=times, rtol=1e-10, atol=1e-12).y.T.reshape(-1, n, n)


@pytest.mark.parametrize("window", [0.5, 4.0])
@pytest.mark.parametrize("scale", [0.0, 0.3, 5.0])
def test_any_terminal_weight_leads_to_the_integrators_riccati_path(window: float, scale: float) -> None:
    """Appendix A: Φ(x) = xᵀS_f x, smaller and larger than the settled S, and not a multiple of it."""
    p, weights = turned(20.0), (2.0 * np.eye(2), np.eye(1), 3.0 * np.eye(2), 0.5 * np.eye(1))
    Q, R, W, V = weights
    S, P = solve_continuous_are(p.A, p.B, Q, R), solve_continuous_are(p.A.T, p.C.T, W, V)
    ends = scale * np.array([[2.0, 0.4], [0.4, 0.3]]), scale * np.array([[0.2, -0.1], [-0.1, 3.0]])
    found = horizon_of(p, weights, S, P, window, ends)
    np.testing.assert_allclose(found.S[::-1], integrated(p.A, p.B @ p.B.T, Q, ends[0], found.t), rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(found.P, integrated(p.A.T, 2 * p.C.T @ p.C, W, ends[1], found.t), rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(found.K[-1], p.B.T @ ends[0], atol=1e-12)


def test_the_knob_sets_a_share_of_the_settled_solution_and_its_words_follow() -> None:
    for share, words in ((0.0, "K is 0"), (1.0, "constant"), (2.5, "2.5 times its limit")):
        o = outcome(method="weights", sensor=0.0, terminal=share)
        found, figure = o.study.horizon, next(f for f in LESSON.figures(o) if f.id == "horizon")
        p = turned(0.0)
        S = solve_continuous_are(p.A, p.B, 4 * np.eye(2), np.eye(1))
        np.testing.assert_allclose(found.S[-1], share * S, rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(found.S[::-1], integrated(p.A, p.B @ p.B.T, 4 * np.eye(2), share * S, found.t), rtol=1e-6, atol=1e-8)
        assert words in figure.caption("en") and figure.curves[2].y[-1] == pytest.approx(share, abs=1e-6)
        if share == 1:
            np.testing.assert_allclose(found.S, np.broadcast_to(S, found.S.shape), rtol=1e-8)
        values = LESSON.derived(o)
        assert values["d_end"] == pytest.approx((1 - share) * S[0, 0]) and values["s_start"] == pytest.approx(found.S[0, 0, 0])


@pytest.mark.parametrize("ratio", [1e-4, 0.3, 7.0, 1e4])
@pytest.mark.parametrize("filtering", [False, True])
def test_the_left_half_of_the_symmetric_root_locus_is_what_riccati_chooses(ratio, filtering):
    A, B, C = turned(30.0).A, turned(30.0).B, turned(30.0).C
    A, B = (A.T, C.T) if filtering else (A, B)
    roots = locus(A, B, np.eye(2), np.eye(1), np.array([ratio]))[0]
    S = solve_continuous_are(A, B, ratio * np.eye(2), np.eye(1))
    chosen = np.linalg.eigvals(A - B @ (B.T @ S))
    np.testing.assert_allclose(np.sort_complex(roots[roots.real < 0]), np.sort_complex(chosen), rtol=1e-6)
    np.testing.assert_allclose(np.sort_complex(roots), np.sort_complex(-roots), rtol=1e-7, atol=1e-9)


def test_each_branch_of_the_locus_is_one_curve():
    roots = locus(turned(0.0).A, turned(0.0).B, np.eye(2), np.eye(1), ratios(2))
    steps = np.abs(np.diff(roots, axis=0)) / np.abs(roots[1:])
    assert steps.max() < 0.5, "no branch jumps to another"
    assert {tuple(np.sign(branch.real[[0, -1]])) for branch in roots.T} == {(-1.0, -1.0), (1.0, 1.0)}


# --- the stage ---------------------------------------------------------------------------------------------------------
def words_of(o, k: int = 0) -> list[str]:
    """The words that follow the run on the stage, with the signs of numbers."""
    marks = o.stage.body.marks(o.stage.x[k].tolist(), o.stage.xhat[k].tolist(), 1.0)
    return [label_in_language(words, "en").replace("−", "-") for words, *_ in marks.words]


@pytest.mark.parametrize("sensor", [0.0, 40.0, 90.0])
def test_the_row_of_tiles_is_the_gain_of_the_transposed_plant_and_turns_into_the_column_of_the_observers(sensor):
    """K_d places the poles of Aᵀ − CᵀK_d; transposed, a copy of the row becomes a column beside it."""
    A, C = np.array([[0.0, 1.0], [-1.0, -0.5]]), np.array([[np.cos(np.radians(sensor)), np.sin(np.radians(sensor))]])
    row, column = (outcome(tiles="dual", transposed=degrees, sensor=sensor) for degrees in (0.0, 90.0))
    K_d = np.array([[float(word) for word in words_of(row)[-2:]]])
    np.testing.assert_allclose(np.poly(A.T - C.T @ K_d), [1.0, 1.6, 1.28], atol=0.02)
    L = np.array([[float(word)] for word in words_of(column)[-2:]])
    np.testing.assert_allclose(np.poly(A - L @ C), [1.0, 1.6, 1.28], atol=0.02)
    np.testing.assert_array_equal(L, K_d.T)
    np.testing.assert_allclose([[float(word) for word in words_of(o)[-4:-2]] for o in (row, column)], [K_d[0], K_d[0]])
    poses = [o.stage.body.pose(o.stage.x[0].tolist(), 1.0) for o in (row, column)]
    before, after = (np.array([each[f"tile {k}"].position for k in range(4)]) for each in poses)
    np.testing.assert_allclose(before[:2], after[:2])  # the row itself stays
    np.testing.assert_allclose(before[2:], before[:2], atol=0.005)  # its copy lies in it at first
    np.testing.assert_allclose(before[1] - before[0], [0.66, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(after[3] - after[2], [0.0, 0.0, -0.66], atol=1e-12)
    assert after[2][0] > after[1][0] + 0.58
    seen = [[at[2] > 0 for _, at, _ in o.stage.body.marks(o.stage.x[0].tolist(), o.stage.xhat[0].tolist(), 1.0).words[-4:]]
            for o in (row, column)]
    assert seen == [[True, True, False, False], [True] * 4]
    assert poses[0]["tile 2"].colour == poses[0]["tile 0"].colour == poses[1]["tile 0"].colour != poses[1]["tile 2"].colour


def test_the_tiles_of_k_are_a_row_and_those_of_l_a_column_and_a_turned_sensor_changes_l_alone():
    """A − BK and A − LC have the poles of the boards, with B = (0, 1) and C = (1, 0) or (0, 1)."""
    A, B = np.array([[0.0, 1.0], [-1.0, -0.5]]), np.array([[0.0], [1.0]])
    said = []
    for sensor, C in ((0.0, np.array([[1.0, 0.0]])), (90.0, np.array([[0.0, 1.0]]))):
        o = outcome(tiles="both", sensor=sensor)
        K1, K2, L1, L2 = map(float, words_of(o)[-4:])
        np.testing.assert_allclose(np.poly(A - B @ np.array([[K1, K2]])), [1.0, 1.6, 1.28], atol=0.02)
        np.testing.assert_allclose(np.poly(A - np.array([[L1], [L2]]) @ C), [1.0, 1.6, 1.28], atol=0.02)
        said.append((K1, K2, L1, L2))
        places = [o.stage.body.pose(o.stage.x[0].tolist(), 1.0)[f"tile {k}"].position for k in range(4)]
        assert places[0][2] == places[1][2] and places[0][0] < places[1][0] and places[2][0] == places[3][0] and places[2][2] > places[3][2]
    assert said[0][:2] == said[1][:2] and said[0][2:] != said[1][2:]


def test_the_bars_before_the_block_are_the_sizes_of_e_and_of_the_reversed_dual_state_and_their_product():
    """e(t) = e^{(A−LC)t} e(0), x_d(T − t) = e^{(A−LC)ᵀ(T−t)} (1, 1); a bar has three decades in 1.9 stage units."""
    o = outcome(tiles="pair")
    F = np.array([[0.0, 1.0], [-1.0, -0.5]]) - o.study.L @ np.array([[1.0, 0.0]])
    end = float(o.stage.t[-1])
    for k in (0, len(o.stage.t) // 2, len(o.stage.t) - 1):
        t = float(o.stage.t[k])
        e, x_d = expm(F * t) @ np.array([1.0, 0.0]), expm(F.T * (2.5 - t)) @ np.ones(2)
        sizes = np.array([np.linalg.norm(e), np.linalg.norm(x_d), abs(x_d @ e)])
        poses = o.stage.body.pose(o.stage.x[k].tolist(), 1.0)
        np.testing.assert_allclose([poses[f"bar {j}"].scale[2] for j in range(3)], 1.9 * (np.log10(sizes) + 2) / 3, rtol=2e-3)
        np.testing.assert_allclose([poses[f"begun {j}"].scale[2] for j in range(3)],
                                   [o.stage.body.pose(o.stage.x[0].tolist(), 1.0)[f"bar {j}"].scale[2] for j in range(3)])
        np.testing.assert_allclose([float(word) for word in words_of(o, k)[-3:]], sizes, rtol=0.05)
    assert end == pytest.approx(2.5, abs=0.024)
