"""The bilinear observer's lesson: the paper's numbers, its slips, the three cases, and an error that no input reaches."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from observer_lab.colours import COLOURS
from observer_lab.course.figures.records import TableFigure
from observer_lab.lessons.bilinear_observer.knobs import KNOBS
from observer_lab.lessons.bilinear_observer.lesson import LESSON
from observer_lab.lessons.bilinear_observer.paper_example import DOUBTED, FATAL, OPTIONS, PRINTED_LINES
from observer_lab.lessons.bilinear_observer.problems import (
    FITTING_SENSORS,
    NO_SOLUTION,
    PAPER_PROBLEM,
    PROBLEMS,
    THREE_SENSORS,
    nearest_gain,
)
from observer_lab.lessons.bilinear_observer.study import STATE_JUMP, signal
from observer_lab.plants.bilinear import BILINEAR_PLANT, X0, fitting_functional, with_sensors
from observer_lab.plants.bilinear import WANTED_ROW as WANTED

HAND = ((0.0, 2.5), (0.31, -4.0), (0.4, 4.0), (0.9, 0.0), (1.2, -3.0))
EVERY_INPUT = [
    {"input": "none"}, {"input": "sine"}, {"input": "sine", "amplitude": 4.0, "omega": 30.0},
    {"input": "step", "amplitude": 3.0}, {"input": "square", "amplitude": 4.0, "omega": 17.0},
    {"input": "sweep", "amplitude": 2.0, "omega": 20.0}, {"input": "random", "amplitude": 4.0, "seed": 7},
    {"input": "hand", "hand": HAND},
]


def outcome(**changes):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def table(drawn, name):
    found = next(f for f in LESSON.figures(drawn) if f.id == name)
    assert isinstance(found, TableFigure)
    return found.rows


def test_the_numbers_of_the_paper_come_out():
    m, L = outcome().metrics, outcome().gains["L"]
    assert (round(m["A*"], 2), round(m["B*"], 2), round(m["pi"], 2), m["case"]) == (-6.47, 2.53, 9.29, 3)
    np.testing.assert_array_equal(np.round(L[0], 2), [-12.49, 17.68, -18.99, 9.29])
    assert m["pole"] == pytest.approx(-30, abs=1e-9)
    assert m["first_error"] == pytest.approx(-1318 / 85, abs=1e-11)


def test_step_8_in_printed_decimals_keeps_its_pole_and_its_noise_wherever_the_cross_stands():
    """Of the form that runs: the printed one has −30, those with ẏ the cross's pole; an unstable one beside it is no matter."""
    printed = outcome(gain="rounded", pole=[4.0], noise=0.01).metrics
    assert printed["pole"] == -30 and printed["noise_promised"] == pytest.approx(outcome(noise=0.01).metrics["noise_promised"], rel=1e-3)
    exact = outcome(gain="rounded", pole=[-7.5], form="exact").metrics
    assert exact["pole"] == pytest.approx(-7.5) and exact["law_gap"] < 1e-6
    assert "grows" in outcome(gain="rounded", pole=[4.0], form="exact").live("en")


def test_pi_by_hand_in_exact_numbers():
    with mp.workdps(30):
        a, b = mpf(-304) / 47, mpf(119) / 47
        assert outcome().metrics["pi"] == pytest.approx(float((a + 30) / b), rel=1e-13)
        assert outcome(pole=[-7.5]).metrics["pi"] == pytest.approx(float((a + mpf("7.5")) / b), rel=1e-12)


@pytest.mark.parametrize("change", EVERY_INPUT, ids=lambda c: "-".join(str(v) for v in c.values())[:30])
@pytest.mark.parametrize("form", ["plain", "exact"])
def test_the_error_decays_as_the_pole_says_under_every_input(change, form):
    drawn = outcome(form=form, **change)
    run = drawn.study.run
    index = ("plain", "exact").index(form)
    law = -1318 / 85 * np.exp(-30 * run.t)
    np.testing.assert_allclose(run.errors[:, index, 0], law, rtol=0, atol=2e-9)
    assert drawn.metrics["law_gap"] < 1e-9
    assert {c.id: c.holds for c in drawn.checks}["law"]


@pytest.mark.parametrize("pole", [-60.0, -12.0, -1.0, 2.0])
def test_the_error_follows_the_pole_that_is_chosen(pole):
    run = outcome(pole=[pole], input="square").study.run
    law = run.errors[0, 0, 0] * np.exp(pole * run.t)
    np.testing.assert_allclose(run.errors[:, 0, 0], law, rtol=0, atol=1e-7 * np.max(np.abs(law)))


def test_inputs_differ_and_move_the_plant():
    t = np.linspace(0, 2, 401)
    drawn = [signal(LESSON.apply(LESSON.start(), c))(t) for c in EVERY_INPUT]
    assert len({tuple(np.round(u, 9)) for u in drawn}) == len(EVERY_INPUT)
    assert all(np.shape(u) == t.shape for u in drawn)
    np.testing.assert_allclose(signal(LESSON.start())(t), np.sin(2 * t))  # the paper's


def test_the_plant_moves_as_an_adaptive_solver_says():
    run = outcome().study.run

    def rate(t, x):
        return BILINEAR_PLANT.A @ x + np.sin(2 * t) * (BILINEAR_PLANT.B[:, 0] + BILINEAR_PLANT.F @ x)
    peer = solve_ivp(rate, (0, 2), np.ones(6), "DOP853", [0.5, 1.0, 2.0], rtol=1e-11, atol=1e-13).y.T
    np.testing.assert_allclose(run.x[[100, 200, 400]], peer, atol=1e-7)
    np.testing.assert_allclose(run.g[:, 0], run.x @ WANTED[0], atol=1e-12)


# --- the slips -----------------------------------------------------------------------------------------------------
def test_with_the_printed_gain_the_observer_runs_away():
    drawn = outcome(gain="printed")
    assert round(drawn.metrics["pole"], 2) == 5.02 and drawn.metrics["late_error"] > 1e5
    assert not {c.id: c.holds for c in drawn.checks}["stable"]


def test_only_one_printed_line_moves_the_pole_far():
    o = PROBLEMS[PAPER_PROBLEM].solved
    alone = {line.id: line.alone(o) for line in DOUBTED if line.alone is not None}
    assert round(alone.pop(FATAL), 2) == 5.02
    assert max(abs(pole + 30) for pole in alone.values()) < 0.1
    assert len(OPTIONS) == len(DOUBTED) + 1


def test_printed_lines_are_ours_to_their_digits_except_the_two_slips():
    o = PROBLEMS[PAPER_PROBLEM].solved
    wrong = []
    for line in PRINTED_LINES:
        printed = np.array([float(word) for word in line.printed.replace("−", "-").split(",")])
        ours = line.ours(o)
        assert ours is not None and printed.size == np.size(ours), line.id
        if np.max(np.abs(printed - np.ravel(ours))) > 0.005 * (1 + 1e-9):
            wrong.append(line.id)
    assert wrong == ["l4", "chi-y"]


def test_printed_decimals_leave_a_floor():
    assert 4e-3 < outcome(gain="rounded").metrics["half_error"] < 7e-3
    assert outcome().metrics["half_error"] < 1e-10


@pytest.mark.parametrize("l4", [0.0, 3.0, 12.0])
def test_the_pole_moves_by_five_for_one_of_l4(l4):
    # (V₁ A T₂)₄ = A₄₅/5 = 5
    assert outcome(gain="typed", l4=l4).metrics["pole"] == pytest.approx(-30 + 5 * (158 / 17 - l4), abs=1e-9)


def test_what_is_not_shown_changes_nothing():
    one, two = outcome(problem=FITTING_SENSORS), outcome(problem=FITTING_SENSORS, gain="printed", l4=1.0, pole=[-5.0])
    np.testing.assert_array_equal(one.study.run.errors, two.study.run.errors)


# --- three cases ---------------------------------------------------------------------------------------------------
def test_each_problem_lights_its_case():
    lit = {name: "".join("X" if c.holds else "." for c in outcome(problem=name).checks[:5]) for name in PROBLEMS}
    assert lit == {PAPER_PROBLEM: "..XXX", THREE_SENSORS: "X...X", FITTING_SENSORS: ".X..X", NO_SOLUTION: "..X.."}


def test_ranks_as_numpy_counts_them():
    for name, (of_q, of_both) in {PAPER_PROBLEM: (3, 3), THREE_SENSORS: (3, 4), FITTING_SENSORS: (3, 3), NO_SOLUTION: (3, 3)}.items():
        o = PROBLEMS[name].solved
        both = np.vstack([o.Q, o.right])
        assert (np.linalg.matrix_rank(o.Q), np.linalg.matrix_rank(both, tol=1e-9)) == (of_q, of_both), name
        assert [row[2] for row in table(outcome(problem=name), "singular")] == [f"{of_q} / {len(o.Q)}", f"{of_both} / {len(o.Q) + 1}"]


def test_without_a_solution_the_input_drives_the_error():
    calm, driven = outcome(problem=THREE_SENSORS, input="none"), outcome(problem=THREE_SENSORS, input="step", amplitude=3.0)
    assert driven.metrics["late_error"] > 100 * calm.metrics["late_error"] > 0.1
    o = PROBLEMS[THREE_SENSORS].solved
    assert np.linalg.norm(o.right - nearest_gain(o) @ o.Q) > 1e-3 * np.linalg.norm(o.right)


def test_three_sensors_watch_the_number_that_fits_them():
    drawn = outcome(problem=FITTING_SENSORS, input="step", amplitude=3.0)
    assert drawn.metrics["pole"] == pytest.approx(-24.4355, abs=5e-5) and drawn.metrics["law_gap"] < 1e-9
    assert np.round(PROBLEMS[FITTING_SENSORS].K[0], 2).tolist() == [1, 2, 3, 0.67, 5, -3.06]


def test_the_fitting_functional_meets_the_conditions_by_definition():
    plant = with_sensors((0, 1, 2))
    P, pole = fitting_functional(plant, -30.0)
    np.testing.assert_allclose((P @ plant.F)[0, 3:], 0, atol=1e-12)
    np.testing.assert_allclose((P @ plant.A - pole * P)[0, 3:], 0, atol=1e-11)


def test_a_family_whose_pole_cannot_be_moved():
    o = PROBLEMS[NO_SOLUTION].solved
    assert o.case == 3 and o.controllable is False and not o.B_star.any()
    assert outcome(problem=NO_SOLUTION).metrics["pole"] == pytest.approx(240 / 17, abs=1e-9)
    board = outcome(problem=NO_SOLUTION).boards[1]
    assert board.knob is None and board.fixed and not board.poles


# --- forms, kick, exam ---------------------------------------------------------------------------------------------
def test_the_form_with_the_true_derivative_is_the_same_observer():
    run = outcome(input="hand", hand=HAND).study.run
    np.testing.assert_allclose(run.estimates[:, 1], run.estimates[:, 0], atol=1e-9)


def test_the_differentiator_leaves_an_error_in_proportion_to_its_lag():
    late = [outcome(form="filtered", tau=tau).metrics["half_error"] for tau in (0.002, 0.004, 0.02)]
    assert late[1] / late[0] == pytest.approx(2, rel=0.02) and late[2] / late[0] == pytest.approx(10, rel=0.05)
    assert late[2] == pytest.approx(0.097, abs=5e-4)


@pytest.mark.parametrize("form", ["plain", "exact"])
def test_a_kick_is_an_error_that_dies_out_too(form):
    run = outcome(kick=0.5, form=form).study.run
    index = ("plain", "exact").index(form)
    jump = run.errors[100, index, 0] - run.errors[99, index, 0] * np.exp(-30 * 0.005)
    assert jump == pytest.approx(-WANTED[0] @ STATE_JUMP, abs=1e-8)
    after = run.t >= 0.5
    law = run.errors[100, index, 0] * np.exp(-30 * (run.t[after] - 0.5))
    np.testing.assert_allclose(run.errors[after, index, 0], law, atol=2e-9)


def test_the_stage_shows_g_and_lights_only_what_is_measured():
    for name, problem in PROBLEMS.items():
        stage = outcome(problem=name).stage
        assert stage is not None and stage.xhat is not None and stage.body is problem.body
        np.testing.assert_allclose(stage.x[:, 6], stage.x[:, :6] @ problem.K[0], atol=1e-9 * np.abs(stage.x).max())
        np.testing.assert_array_equal(stage.x[:, :6], stage.xhat[:, :6])
        poses = [problem.body.pose(stage.x[k].tolist(), 1.0) for k in (0, 40)]
        sizes = np.log10(np.clip(np.abs([stage.xhat[k, 6] - stage.x[k, 6] for k in (0, 40)]), 1e-12, 1e4))
        np.testing.assert_allclose([pose["bar 1"].scale[2] for pose in poses], 3.2 * np.maximum((sizes + 12) / 16, 0.004), atol=0.02)
        assert problem.body.marks is not None
        for k, size in zip((0, 40), sizes, strict=True):
            said = problem.body.marks(stage.x[k].tolist(), stage.xhat[k].tolist(), 1.0).words[1][0]
            number = said.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-", "≤≥ ")).replace("·10", "e").replace("10-", "1e-")
            assert np.log10(float(number)) == pytest.approx(size, abs=0.03), said
        dark = {p.colour for p in problem.body.parts if p.name == "lamp 3"} == {COLOURS["dark"]}
        assert dark == (3 not in problem.measured)
        assert [p.name for p in problem.body.parts if p.twin] == ["large level"]


def unknown_by_hand(o, L) -> list[tuple[float, float]]:
    """(without L, with it) of the three terms, from the printed condition: w = V x for V = [V₁; V₂] = [T₁ T₂ T₃]⁻¹."""
    T1, T2, T3 = o.T
    V = np.linalg.inv(np.hstack([T1, T2, T3]))
    V1, V2 = V[:T1.shape[1]], V[T1.shape[1]:T1.shape[1] + 1]
    terms = o.plant.F @ T2, o.plant.A @ T3, o.plant.F @ T3
    return [(np.linalg.norm(V2 @ each), np.linalg.norm((V2 - L @ V1) @ each)) for each in terms]


@pytest.mark.parametrize(("values", "gone"), [({"problem": "paper"}, True), ({"problem": "stuck"}, True), ({"problem": "three"}, False),
                                              ({"problem": "paper", "gain": "typed", "l4": 12.9}, False)])
def test_a_pipe_is_as_thick_as_its_unknown_term_and_empty_behind_the_plate_where_the_gain_removes_it(values, gone):
    """Cross-sections are sizes, beside the largest of the terms without L."""
    o = outcome(step=7, **values)
    sizes = unknown_by_hand(o.study.observer, o.study.setting.L)
    largest = max(alone for alone, _ in sizes)
    poses = o.stage.body.pose(o.stage.x[50].tolist(), 1.0)
    plate = poses["gain plate"].position[0]
    for k, (alone, left) in enumerate(sizes):
        grey, pink = poses[f"term {k}"], poses[f"left {k}"]
        assert grey.scale[0] ** 2 == pytest.approx(alone / largest, rel=1e-6)
        assert pink.scale[0] ** 2 == pytest.approx(min(left / largest, 1.4), rel=1e-6, abs=2e-6)
        assert grey.position[0] + grey.scale[2] == pytest.approx(plate) == pink.position[0]
    assert (max(left for _, left in sizes) < 1e-6) == gone == all(poses[f"left {k}"].scale[0] < 0.01 for k in range(3))


@pytest.mark.parametrize("form", ["plain", "filtered"])
def test_the_block_of_the_gain_stands_on_the_table_and_bears_its_name_on_its_front(form):
    o = outcome(step=7, form=form)
    poses, parts = o.stage.body.pose(o.stage.x[50].tolist(), 1.0), {part.name: part for part in o.stage.body.parts}
    (across, y, z), (_, deep, high) = poses["gain plate"].position, parts["gain plate"].shape.size
    table = poses["table"].position[2] + parts["table"].shape.size[2] / 2
    assert poses["gain post"].position == pytest.approx((across, y, table))
    assert poses["gain post"].scale[2] == pytest.approx(z - high / 2 - table)
    (at,) = [place for name, place in o.stage.body.labels if name == "L"]
    assert at[0] == across and at[1] < y - deep / 2 and abs(at[2] - z) < high / 4


def missed_by_hand(run, plant, tau: float) -> np.ndarray:
    """ẏ (m,) less (y − y_f)/τ with y_f = y/(τs + 1), by fine steps of a filter of our own, from ẏ = C (A x + B u + u F x)."""
    y = run.x @ plant.C.T
    fine = np.arange(0, 2 + 1e-9, 0.0005)
    smooth = np.array([CubicSpline(run.t, each)(fine) for each in y.T]).T
    slow = smooth.copy()
    for k in range(1, len(fine)):
        slow[k] = slow[k - 1] + 0.0005 * (0.5 * (smooth[k] + smooth[k - 1]) - slow[k - 1]) / (tau + 0.00025)
    u = run.u[:, None]
    rate = (run.x @ plant.A.T + u * plant.B.T + u * (run.x @ plant.parts[0].T)) @ plant.C.T
    return rate - ((smooth - slow) / tau)[::10]


@pytest.mark.parametrize(("pole", "tau"), [(-30.0, 0.02), (-60.0, 0.02), (-30.0, 0.004)])
def test_the_pipe_of_the_differentiator_is_as_thick_as_what_it_misses_and_past_the_plate_as_l_times_that(pole, tau):
    """Cross-sections are ‖m‖ and |L m| beside 8; both sizes are written; no pipe of terms beside it."""
    o = outcome(step=6, form="filtered", tau=tau, pole=[pole])
    missed, L = missed_by_hand(o.study.run, BILINEAR_PLANT, tau), o.gains["L"]
    for k in (200, 212, 280, 360):
        poses = o.stage.body.pose(o.stage.x[k].tolist(), 1.0)
        sizes = np.linalg.norm(missed[k]), abs((L @ missed[k]).item())
        for name, size, word in zip(("missed", "missed times L"), sizes, said(o.stage, k)[1:3], strict=True):
            assert poses[name].scale[0] ** 2 == pytest.approx(min(size / 8, 1.4), rel=0.05), (k, name)
            assert float(word) == pytest.approx(size, rel=0.08)
        assert poses["missed"].position[0] + poses["missed"].scale[2] == pytest.approx(poses["gain plate"].position[0])
        assert poses["missed times L"].position[0] == pytest.approx(poses["gain plate"].position[0])
        assert "term 0" not in poses
    assert "missed" not in outcome(step=6, form="plain").stage.body.pose(outcome(step=6).stage.x[0].tolist(), 1.0)


def said(stage, k: int) -> list[str]:
    """The words of the stage at a sample, those out of sight left out: sizes of bars first, of pipes, and arrows of gauges."""
    words = stage.body.marks(stage.x[k].tolist(), stage.xhat[k].tolist(), 1.0).words
    return [word for word, at, _ in words if at[2] > -5]


@pytest.mark.parametrize("kick", [0.5])
def test_what_the_differentiator_misses_jumps_with_a_kick_and_with_noise_as_l_times_it_does(kick):
    """A sensor that the kick reaches, and noise: the length is at least |L m|/‖L‖, which the run's own filter gives."""
    for changes in ({"problem": NO_SOLUTION, "kick": kick}, {"noise": 0.01}):
        run, s = (o := outcome(form="filtered", **changes)).study.run, o.study.setting
        along = np.abs(run.fed[:, 0] - run.fed[:, 1]) / np.linalg.norm(s.L)
        late = slice(20, None)
        assert np.all(run.missed[late] >= 0.97 * along[late] - 0.02), changes
        assert np.max(run.missed[late]) > 3 * np.median(run.missed[late])


def test_the_bar_of_the_error_is_even_where_a_differentiator_is_used():
    """3.2 stage units for 0.2, its size beside it, an arrow where it would be longer."""
    for pole in (-30.0, -60.0):
        stage = (o := outcome(form="filtered", pole=[pole])).stage
        for k in (10, 212, 360):
            error = abs(o.study.run.estimates[k, 2, 0] - o.study.run.x[k] @ WANTED[0])
            assert stage.body.pose(stage.x[k].tolist(), 1.0)["bar 0"].scale[2] == pytest.approx(min(16 * error, 3.2), abs=0.013)
            assert float(said(stage, k)[0].removeprefix("→ ")) == pytest.approx(error, rel=0.06)
            assert said(stage, k)[0].startswith("→") == (error > 0.2)
    plain = outcome(form="exact").stage.body
    assert [name for name, _ in plain.labels if name in ("0.1", "0.2")] == []


def test_a_gauge_whose_value_is_far_past_its_end_has_an_arrow():
    """A column goes 1 up or 0.78 down, 0.28 for one of a state and 0.026 for one of g; an arrow from twice an end on."""
    o = outcome(input="step", amplitude=3.0)
    seen = set()
    for k in range(0, 401, 20):
        values = [*(0.28 * o.study.run.x[k]), 0.026 * o.study.run.g[k, 0]]
        wanted = ["↑" for v in values if v > 2.0] + ["↓" for v in values if v < -1.56]
        assert sorted(w for w in said(o.stage, k) if w in "↑↓") == sorted(wanted), k
        seen |= set(wanted)
    assert seen == {"↑", "↓"}
    assert not [w for w in said(outcome().stage, 6) if w in "↑↓"]


def test_dark_gauges_stand_beside_the_large_one_and_pipes_run_in_the_free_space_between_their_plates():
    for problem in PROBLEMS.values():
        for form in ("plain", "filtered"):
            stage = outcome(problem=problem.id, step=6, form=form).stage
            poses = stage.body.pose(stage.x[200].tolist(), 1.0)
            size = {part.name: part.shape.size[0] for part in stage.body.parts if part.name.startswith(("back", "large back"))}
            places = {i: poses[f"column {i}"].position[0] for i in range(6)}
            dark = {places[i]: i for i in range(6) if i not in problem.measured}
            assert max(places[i] for i in problem.measured) < min(dark) and max(dark) < poses["gain plate"].position[0]
            begin = max(dark) + size[f"back {dark[max(dark)]}"] / 2
            end = poses["large back"].position[0] - size["large back"] / 2
            firsts, lasts = ([f"term {k}" for k in range(3)], [f"left {k}" for k in range(3)]) if form == "plain" else (
                ["missed"], ["missed times L"])
            assert [poses[name].position[0] for name in firsts] == pytest.approx([begin] * len(firsts))
            assert [poses[n].position[0] + poses[n].scale[2] for n in lasts] == pytest.approx([end] * len(lasts))
            assert end - begin > 1.4


def test_every_step_has_its_formulas_and_rows():
    seen = set()
    for step in range(1, 9):
        drawn = outcome(step=step)
        assert drawn.formulas and table(drawn, "step")
        seen.add(tuple(f.latex for f in drawn.formulas))
    assert len(seen) == 8 and KNOBS[0].name == "step"


# --- noise on y, and what sizes promise -----------------------------------------------------------------------------
def test_what_noise_does_is_as_the_step_says():
    rms = {form: outcome(noise=0.01, form=form).metrics["noise_rms"] for form in ("plain", "filtered")}
    assert f"{rms['plain']:.2f}" == "0.33" and f"{rms['filtered']:.2f}" == "0.15"
    assert f"{outcome(noise=0.01, pole=[-8.4]).metrics['noise_rms']:.2f}" == "0.12"
    assert f"{np.linalg.norm(outcome().study.observer.without_derivative.G_y):.0f}" == "31"
    quick, slow = (outcome(noise=0.01, form="filtered", tau=tau).metrics["noise_promised"] for tau in (0.001, 0.1))
    assert slow < quick < outcome(noise=0.01).metrics["noise_promised"], "a smaller τ passes more, up to the form without ẏ"
    still, held = (outcome(noise=0.01, form="exact", input="step", amplitude=size).metrics["noise_rms"] for size in (0.0, 3.0))
    assert held > 1.2 * still, "u multiplies noise"


def test_sizes_and_the_pair_are_lights():
    lit = {name: "".join("X" if c.holds else "." for c in outcome(problem=name).checks[6:]) for name in PROBLEMS}
    assert lit == {PAPER_PROBLEM: "XXX", THREE_SENSORS: "X.X", FITTING_SENSORS: "X.X", NO_SOLUTION: "XXX"}
    n, m = 6, {name: len(problem.measured) for name, problem in PROBLEMS.items()}
    assert all((lit[name][1] == "X") == (3 * m[name] + 1 >= 2 * n) for name in PROBLEMS)


# --- tasks are not solved by the wrong design, nor by a knob at its stop -----------------------------------------------------
@pytest.mark.parametrize(
    "task, values",
    [
        ("slip", {"line": FATAL, "gain": "printed"}),
        ("slip", {"line": FATAL, "gain": "typed"}),
        ("slip", {"gain": "typed", "l4": 9.29}),
        ("runaway", {"input": "step", "amplitude": 4.0}),
        ("runaway", {"input": "step", "amplitude": 3.0}),
        ("lag", {"form": "filtered", "tau": 0.001}),
        ("lag", {"form": "filtered", "tau": 0.005}),
        ("lag", {"form": "plain"}),
        ("three-sensors", {"problem": FITTING_SENSORS}),
        ("three-sensors", {"problem": FITTING_SENSORS, "chi0": 15.5}),
        ("three-sensors", {"problem": THREE_SENSORS}),
    ],
)
def test_a_task_is_not_solved_by_a_click_or_a_stop(task: str, values: dict[str, object]) -> None:
    assert not next(t for t in LESSON.tasks if t.id == task).check(outcome(**values)).solved


def test_the_first_chi_of_the_third_task_is_g_less_what_the_sensors_say() -> None:
    o = outcome(problem=FITTING_SENSORS, chi0=4.5)
    assert abs(o.metrics["first_error"]) < 0.05 and o.metrics["law_gap"] <= 1e-6


def test_an_observer_that_runs_away_leaves_the_plants_motion_as_it_is() -> None:
    run = outcome(problem=NO_SOLUTION, input="none").study.run
    assert np.abs(run.estimates).max() > 1e11
    own = np.array([expm(PROBLEMS[NO_SOLUTION].plant.A * t) @ X0 for t in run.t[::50]])
    np.testing.assert_allclose(run.x[::50], own, rtol=0, atol=1e-9)


def test_what_the_offsets_of_sensors_do_is_what_a_long_run_shows():
    """The numbers of the task, against plant and observer integrated together to their rest, one sensor off at a time."""
    task = next(t for t in LESSON.tasks if t.id == "offsets")

    def off(pole):
        o = outcome(pole=[pole])
        form = o.study.observer.forms(o.gains["L"])[1]
        both = np.block([[BILINEAR_PLANT.A, np.zeros((6, 1))], [form.Y @ BILINEAR_PLANT.C, form.A]])
        ends = []
        for offset in np.eye(4):
            whole = np.zeros((8, 8))
            whole[:7, :7], whole[:7, 7] = both, np.concatenate([np.zeros(6), form.Y @ offset])
            x = (expm(60.0 * whole) @ np.append(X0, [0.0, 1.0]))[:7]
            ends.append((form.G_y @ (BILINEAR_PLANT.C @ x[:6] + offset) + form.G_z @ x[6:] - WANTED @ x[:6]).item())
        return float(np.linalg.norm(ends)), task.check(o)
    for pole, said in ((-30.0, "25.2"), (-2.0, "85.2"), (-8.4, "16.6")):
        long, verdict = off(pole)
        assert f"{long:.1f}" == said and f"norm {long:.2f}" in verdict.text("en") and verdict.solved == (pole == -8.4)
    assert [task.check(outcome(pole=[p])).solved for p in (-9.1, -9.0, -7.9, -7.8)] == [False, True, True, False]
    assert not task.check(outcome(pole=[-8.4], gain="rounded")).solved


def test_the_bars_of_the_four_problems_are_the_poles_that_their_observers_reach() -> None:
    for name in PROBLEMS:
        figure = next(f for f in LESSON.figures(outcome(problem=name)) if f.id == "case_poles")
        bars = {int(c.xs[0]): float(c.y[-1]) for c in figure.curves if c.xs[0] == c.xs[-1]}
        expected = {k: float(np.linalg.eigvals(p.solved.forms(p.solved.L)[0].A).real[0]) for k, p in enumerate(PROBLEMS.values())
                    if p.solved.case != 1}
        assert bars == pytest.approx(expected, abs=1e-6) and [p.x for p in figure.points] == [1.0]
