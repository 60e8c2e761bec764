"""Laws and published numbers of the lesson "robust observer"; the source has u = +K x, the lesson u = −K x̂."""

import itertools
import math

import numpy as np
import pytest
from lesson_checks import carried
from scipy.integrate import solve_ivp

from observer_lab.course.knobs import KnobError
from observer_lab.engine import EngineError, ShapeError, functional_observer, rlo, simulate_functional
from observer_lab.engine.observers import Region, vertices, worst_error_gain
from observer_lab.lessons.robust_observer.criterion import criterion_1, criterion_2, steering
from observer_lab.lessons.robust_observer.job import swept
from observer_lab.lessons.robust_observer.knobs import COLUMNS, REMARKS, SENSITIVITY_LINES
from observer_lab.lessons.robust_observer.lesson import LESSON
from observer_lab.lessons.robust_observer.paper_slips import claimed_columns, free_columns, remark_3, true_size
from observer_lab.lessons.robust_observer.study import EXAMPLE_CASES, FREQUENCIES, errors, observer_of
from observer_lab.plants.duan import EXAMPLE_1, EXAMPLE_2, outer_input

START = LESSON.start()
SECOND = LESSON.apply(START, {"example": "2"})


def design(**changes):
    return LESSON.apply(START, changes)


def outcome(**changes):
    return LESSON.compute(design(**changes))


def finished(o):
    *_, (fraction, last) = LESSON.job.outcomes(o)
    assert fraction == 1.0
    return last


def table(o, name):
    return next(f for f in LESSON.figures(o) if f.id == name).rows


# --- example 1 -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("s", [-10, -5, -3, -5 / 3, -1, -0.3])
def test_example_1_is_as_printed_once_the_sign_of_u_is_turned(s):
    g = outcome(pole=(s,)).gains
    printed = {"F": [[s]], "T": [[1, s]], "L": [[-s * s - 4 * s - 3]], "N": [[-30]], "M": [[50 + 30 * s]], "K": [[-30, 50]]}
    for name, matrix in printed.items():
        np.testing.assert_allclose(g[name] * (-1 if name in "KNM" else 1), matrix, atol=1e-11)


def test_the_table_shows_both_signs():
    rows = {row[0]: row[1:] for row in table(outcome(), "numbers")}
    assert rows["N"] == ("30", "−30") and rows["M"] == ("100", "−100") and rows["L"] == ("−8", "−8")


@pytest.mark.parametrize(("s", "J"), [(-5 / 3, 38 / 9), (-1, 22), (-3, 46), (-5, 118), (-10, 333)])
def test_example_1_published_values_of_J(s, J):
    assert outcome(pole=(s,)).metrics["J"] == pytest.approx(J, rel=1e-12)


@pytest.mark.parametrize("norm", ["1", "2", "inf"])
@pytest.mark.parametrize("weights", [(1, 1, 1), (0.3, 2, 0.7), (2, 0, 1)])
def test_the_drawn_J_of_example_1_is_the_engines_in_every_norm(norm, weights):
    a, b, c = weights
    for s in (-9.3, -4, -5 / 3, -0.4):
        d = design(norm=norm, alpha=a, beta=b, gamma=c, pole=(s,))
        assert criterion_1(np.array([s]), d).sum() == pytest.approx(observer_of(d).J, rel=1e-12, abs=1e-12)


def test_the_job_finds_minus_5_thirds_by_optimisation_in_every_norm():
    found = finished(outcome())
    for norm in ("1", "2", "inf"):
        assert found.metrics[f"s_rlo_{norm}"] == pytest.approx(-5 / 3, abs=1e-6)
        assert found.metrics[f"J_rlo_{norm}"] == pytest.approx(38 / 9, abs=1e-5)
    assert [row[1] for row in table(found, "found")] == ["1", "1", "1"]


def test_without_the_weight_of_M_the_optimum_moves_to_where_L_vanishes():
    found = finished(outcome(gamma=0.0))
    assert found.metrics["s_rlo_2"] == pytest.approx(-1, abs=1e-6)
    assert found.metrics["J_rlo_2"] == pytest.approx(2, abs=1e-5)


def test_the_region_binds_the_search():
    assert finished(outcome(region_low=-8.0, region_high=-3.0)).metrics["s_rlo_2"] == pytest.approx(-3, abs=1e-6)


def test_on_the_model_the_error_forgets_v_and_the_plant():
    o = outcome(pole=(-5.0,)).study.model
    np.testing.assert_allclose(o.e, -111 * np.exp(-5 * o.t), atol=1e-9)
    o = outcome(pole=(-5 / 3,)).study.model
    np.testing.assert_allclose(o.e, -11 * np.exp(-5 / 3 * o.t), atol=1e-10)


@pytest.mark.parametrize(("s", "start", "amplitude"), [(-5, -116, 0.941342), (-5 / 3, -11, 0.431366)])
def test_figure_1_start_and_steady_amplitude_of_the_perturbed_loop(s, start, amplitude):
    o = outcome(pole=(s,))
    run = o.study.true
    assert o.metrics["error_start"] == pytest.approx(start, abs=1e-10)  # at −5/3 as on the model, since M = 0
    late = run.t > 5.4
    wave = np.column_stack([np.sin(5 * run.t[late]), np.cos(5 * run.t[late])])
    fitted = np.hypot(*np.linalg.lstsq(wave, run.e[late], rcond=None)[0])
    assert fitted == pytest.approx(amplitude, abs=5e-4)  # what is left of the transient after 5.4 s
    at_5 = np.interp(5 / (2 * np.pi), FREQUENCIES, o.study.now)
    assert 4 * at_5 == pytest.approx(amplitude, rel=5e-3)  # read off the frequency curve


def test_the_prediction_is_true_the_slow_pole_errs_least_at_the_end():
    late = {s: outcome(pole=(s,)).metrics["late_error"] for s in (-10, -5, -3, -5 / 3, -0.4)}
    assert min(late, key=late.get) == -5 / 3 and late[-10] > late[-5] > late[-3] > 1.3 * late[-5 / 3]


def brute(s, omega, dA, dC):
    """|e_u/v| from the paper's equations: u = N z + M y + v, ż = s z + L y + T B u."""
    N, M, L = -30.0, 50 + 30 * s, -(s * s + 4 * s + 3)
    A, C, B, TB = np.array([[0, -3], [1, -4]]) + dA, np.array([0, 1]) + dC, np.array([2.0, 1.0]), 2 + s
    whole = np.block([[A + np.outer(B, M * C), (N * B)[:, None]], [(L + TB * M) * C, s + TB * N]])
    into, out = np.append(B, TB), np.append(M * C - [-30, 50], N)
    solved = np.linalg.solve(1j * omega[:, None, None] * np.eye(3) - whole, into[:, None] + 0j)
    return np.abs(out @ solved[:, :, 0].T)


@pytest.mark.parametrize("s", [-5.0, -5 / 3, -1.3])
def test_the_worst_of_the_eight_vertices_is_that_of_the_papers_equations(s):
    o = outcome(pole=(s,))
    corners = [np.array([[0, 0], [0.1 * a, 0.4 * b]]) for a, b in itertools.product((1, -1), repeat=2)]
    grid = np.max([brute(s, 2 * np.pi * FREQUENCIES, dA, np.array([0, 0.05 * c])) for dA in corners for c in (1, -1)], axis=0)
    np.testing.assert_allclose(o.study.worst, grid, rtol=1e-9)
    np.testing.assert_allclose(o.study.now, brute(s, 2 * np.pi * FREQUENCIES, np.array([[0, 0], [0.1, -0.4]]), np.array([0, 0.05])),
                               rtol=1e-9)


def exact(s):
    return worst_error_gain(swept(START, s), vertices(EXAMPLE_1.wrong, (0.1, 0.4), (0.05,)))


def test_minus_5_thirds_is_good_but_not_the_best_in_the_worst_case():
    worst = {s: outcome(pole=(s,)).metrics["worst_gain"] for s in (-1.3, -5 / 3, -5)}
    assert worst[-1.3] == pytest.approx(0.820, abs=1e-3) and worst[-5 / 3] == pytest.approx(0.874, abs=1e-3)
    assert worst[-1.3] < worst[-5 / 3] < worst[-5]
    assert all(worst[s] == pytest.approx(exact(s), rel=1e-6) for s in worst)
    found = finished(outcome()).metrics
    assert found["s_least_worst"] == pytest.approx(-1.3, abs=0.08) and 0.815 < found["least_worst"] < 0.8203


# --- example 2 -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("s1", "s2", "w"), [(-4, -2.5, 1.2), (-9, -0.5, 0.0), (-3, -2, -1.4)])
def test_example_2_is_as_printed_once_the_sign_of_u_is_turned(s1, s2, w):
    g = outcome(example="2", pair=(s1, s2), w12=w).gains
    W, back = np.array([[1, w], [0, 1]]), np.array([[1, -w], [0, 1]])
    np.testing.assert_allclose(g["F"], W @ np.diag([s1, s2]) @ back, atol=1e-11)
    np.testing.assert_allclose(g["T"], W @ [[s * s + 3 * s + 2, s + 3, 1] for s in (s1, s2)], atol=1e-10)
    np.testing.assert_allclose(g["L"], W @ [[-s * (s + 1) * (s + 2)] for s in (s1, s2)], atol=1e-10)
    np.testing.assert_allclose(-g["N"], np.array([[1 - s2, s1 - 1]]) / (s2 - s1) @ back, atol=1e-10)
    np.testing.assert_allclose(-g["M"], [[1 + s1 + s2 - s1 * s2]], atol=1e-10)


@pytest.mark.parametrize("norm", ["1", "2", "inf"])
@pytest.mark.parametrize("pair", [(-4, -2.5), (-9, -0.5), (-3 + 2j, -3 - 2j)])
@pytest.mark.parametrize(("w", "weights"), [(0.0, (1, 1, 1)), (1.2, (0.5, 2, 0.3)), (-1.7, (3, 0.2, 1))])
def test_the_drawn_J_of_example_2_is_the_engines(norm, pair, w, weights):
    d = design(example="2", norm=norm, pair=pair, w12=w, **dict(zip(("alpha", "beta", "gamma"), weights, strict=True)))
    upper, lower = (complex(p) if complex(p).imag else float(p.real) for p in pair)
    assert criterion_2(np.array([upper]), np.array([lower]), d).sum() == pytest.approx(observer_of(d).J, rel=1e-10)


def test_the_mapped_N_is_the_engines():
    for s1, s2 in ((-4, -2.5), (-2.1, -2), (-11, -0.3)):
        o = observer_of(design(example="2", pair=(s1, s2), w12=0.0))
        assert steering(np.array(s1), np.array(s2)) == pytest.approx(np.abs(o.N).max(), rel=1e-9)


@pytest.mark.slow
def test_rlo_raises_the_order_of_example_2_and_keeps_to_the_region():
    o = finished(LESSON.compute(SECOND))
    values = [float(row[3]) for row in table(o, "found")]
    assert values[0] > values[1] > values[2]  # norms 1, 2, ∞: each bounds the next
    for _, found in o.study.search.found:
        first, second = found.attempts
        assert (first.order, first.feasible, second.order, second.feasible) == (1, False, 2, True)
        poles = found.observer.poles.real
        assert np.all(poles >= -10) and np.all(poles <= -0.5) and found.observer.condition <= 50.001


def test_one_state_for_example_2_would_need_an_unstable_pole():
    t = np.array([1 + 3 + 2, 1 + 3, 1.0])  # (s² + 3s + 2, s + 3, 1) at s = +1
    rest = EXAMPLE_2.K_printed[0] - EXAMPLE_2.K_printed[0, 2] * t
    np.testing.assert_allclose(rest[1:], 0)  # what is left of K lies in C
    with pytest.raises(EngineError, match="higher order"):
        rlo(EXAMPLE_2.plant, EXAMPLE_2.K, region=Region(-50, -1e-3), max_order=1)


@pytest.mark.parametrize("w", [1.2, -2.0, 0.5])
def test_W_changes_J_and_nothing_that_can_be_felt_once_the_start_is_carried_along(w):
    plain, apart, carried = (outcome(example="2", w12=x, carried=on) for x, on in ((0.0, False), (w, False), (w, True)))
    assert carried.metrics["coordinate_gap"] < 1e-9 < 1 < apart.metrics["coordinate_gap"]
    np.testing.assert_allclose(carried.study.true.e, plain.study.true.e, atol=1e-9)
    np.testing.assert_allclose(carried.poles["loop"], plain.poles["loop"], atol=1e-8)
    np.testing.assert_allclose(carried.study.worst, plain.study.worst, rtol=1e-8)
    assert carried.metrics["error_index"] == pytest.approx(plain.metrics["error_index"], rel=1e-9)
    assert abs(carried.metrics["J"] - plain.metrics["J"]) > 0.5


def test_the_perturbed_run_of_example_2_against_an_adaptive_solver_of_the_papers_equations():
    o = LESSON.compute(SECOND)
    g = {k: (-v if k in "NMK" else v) for k, v in o.gains.items()}
    A = np.array([[0, 1, 0], [0, 0, 1], [0, -2.01, -3.05]])

    def rate(t, w):
        y = 1.03 * w[0]
        u = (g["N"] @ w[3:]).item() + g["M"].item() * y - 4 * math.sin(5 * t + math.pi / 2)
        return [*(A @ w[:3] + np.array([0, 0, u])), *(g["F"] @ w[3:] + g["L"][:, 0] * y + g["T"] @ [0, 0, 1] * u)]

    peer = solve_ivp(rate, (0, 6), [0.1, 0.1, 0.1, 0.1, 2.19], "DOP853", [3, 6], rtol=1e-12, atol=1e-13).y.T
    run = o.study.true
    np.testing.assert_allclose(np.hstack([run.x, run.z])[[200, 400]], peer, atol=1e-8)


# --- stage, job, refusals --------------------------------------------------------------------------------------------
@pytest.mark.parametrize("d", [START, SECOND])
def test_only_the_input_has_a_ghost_and_their_distance_is_e_u(d):
    o = LESSON.compute(d)
    np.testing.assert_array_equal(o.stage.x[:, :-1], o.stage.xhat[:, :-1])
    np.testing.assert_allclose(o.stage.xhat[:, -1] - o.stage.x[:, -1], o.study.true.e, atol=1e-9)
    beads = [o.stage.body.pose(o.stage.x[9].tolist(), 1.0)[f"{name} {k}"].position[0] for name in ("bead", "model") for k in range(3)]
    reach = [knob.high for name in EXAMPLE_CASES[d["example"]].deltas for knob in LESSON.knobs if knob.name == name]
    shares = [d[name] / high for name, high in zip(EXAMPLE_CASES[d["example"]].deltas, reach, strict=True)]
    np.testing.assert_allclose(np.subtract(beads[:3], beads[3:]), 0.36 * np.array(shares))
    twins = [part.name for part in o.stage.body.parts if part.twin]
    assert twins == ["u level"] and len(o.study.true.z[0]) < len(o.study.true.x[0])


def test_the_job_can_be_stopped_reports_progress_and_leaves_the_picture_as_it_was():
    before = LESSON.compute(SECOND)
    job = LESSON.job.outcomes(before)
    parts = [next(job) for _ in range(6)]
    job.close()
    fractions = [f for f, _ in parts]
    assert fractions == sorted(fractions) and 0 < fractions[-1] < 1
    assert parts[-1][1] is before and before.study.search is None


def test_what_was_found_is_carried_over_while_it_holds():
    found = finished(outcome())
    assert carried(LESSON, found.design, found.study.search, outcome(pole=(-2.0,))).study.search is found.study.search
    for change in ({"alpha": 2.0}, {"region_high": -1.0}, {"example": "2"}, {"a1": 0.2}):
        assert carried(LESSON, found.design, found.study.search, outcome(**change)).study.search is None


def test_the_sweep_of_example_2_stands_at_s_and_s_minus_1():
    np.testing.assert_allclose(np.sort(swept(SECOND, -3.0).poles.real), [-4, -3])


@pytest.mark.parametrize(("changes", "word"), [
    ({"pole": (0.5,)}, "left half plane"),
    ({"example": "2", "pair": (-3, -3)}, "coincide"),
])
def test_poles_that_give_no_observer_get_one_sentence_in_both_languages(changes, word):
    with pytest.raises(KnobError, match=word) as caught:
        outcome(**changes)
    assert caught.value.text("zh")


def test_an_unstable_true_loop_is_told_and_drawn_at_the_edge():
    o = outcome(pole=(-11.0,), a1=0.5, a2=0.5, c=-0.1)
    assert o.metrics["slowest_loop"] > 0 and "unstable" in o.live("en")
    assert all(np.all(np.isfinite(c.y)) for f in LESSON.figures(o) for c in getattr(f, "curves", ()))


# --- slips -----------------------------------------------------------------------------------------------------------
def test_of_the_readings_of_remark_3_one_meets_both_conditions():
    assert [name for name in REMARKS if remark_3(name).met] == ["similar"]
    assert remark_3("printed").dynamics is None
    assert remark_3("left").dynamics > 0.05 and remark_3("left").output < 1e-12
    assert remark_3("forward").dynamics < 1e-12 and remark_3("forward").output > 0.1


def test_of_the_lines_of_example_2_one_has_a_wrong_size():
    sizes = {name: true_size(name) for name in SENSITIVITY_LINES}
    assert sizes == {"TA": (2, 3), "LC": (2, 3), "MC": (1, 3), "N": (1, 2)}


def test_the_columns_of_the_free_parameter():
    assert [name for name in COLUMNS if claimed_columns(name) == free_columns()] == ["mp"]
    plant, K = EXAMPLE_2.plant, EXAMPLE_2.K
    functional_observer(plant, K, 2, poles=[-4, -3], free=np.zeros((1, 0)))
    with pytest.raises(ShapeError):
        functional_observer(plant, K, 2, poles=[-4, -3], free=np.zeros((1, 2)))  # n + p − r*


def test_no_steady_amplitude_is_told_of_a_loop_that_is_unstable() -> None:
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"a1": -0.5}))
    said = next(f.caption("en") for f in LESSON.figures(outcome) if f.id == "e_u")
    assert outcome.metrics["slowest_loop"] > 0 and "grows" in said and "amplitude" not in said


@pytest.mark.parametrize("s", [-0.1, -0.3, -1.0, -5 / 3, -5.0, -11.0])
def test_a_transient_is_not_called_an_amplitude(s: float) -> None:
    """The amplitude of the caption is what a run of many time constants settles to."""
    o = outcome(pole=(s,))
    caption, slowest = next(f for f in LESSON.figures(o) if f.id == "e_u").caption("en"), o.metrics["slowest_loop"]
    if slowest >= 0:
        assert "unstable" in caption and np.isinf(o.study.true.loop.steady())
        return
    dA, _, dC = errors(o.design)
    long = simulate_functional(o.study.observer, outer_input, x0=EXAMPLE_1.x0, z0=EXAMPLE_1.z0, horizon=max(20.0, 12 / -slowest),
                               dt=0.01, dA=dA, dC=dC)
    settled = np.abs(long.e_u[-500:, 0]).max()
    steady = o.study.true.loop.steady()
    assert steady == pytest.approx(settled, rel=0.01)
    assert ("tends to an amplitude" in caption) == (o.metrics["late_error"] >= 1.2 * settled) and f"{steady:.2g}" in caption


def test_two_roads_are_open_to_a_pair_only():
    """The task's numbers, in any coordinates W; real poles with such an M steer with entries above 4."""
    task = next(t for t in LESSON.tasks if t.id == "two-roads")
    for w in (0.0, 1.2, -2.0):
        o = outcome(example="2", w12=w, pair=(-1.1 - 1.05j, -1.1 + 1.05j))
        assert task.check(o).solved and "3.51" in task.check(o).text("en") and "2." in task.check(o).text("en")
    assert not task.check(outcome(example="2", pair=(-1.1 - 0.9j, -1.1 + 0.9j))).solved
    assert not task.check(outcome(example="2", pair=(-1.1 - 1.2j, -1.1 + 1.2j))).solved
    s1, s2 = np.meshgrid(np.linspace(-12, -1.1, 400), np.linspace(-12, -1.1, 400))
    small = (np.abs(1 + s1 + s2 - s1 * s2) <= 3.7) & (np.abs(s1 - s2) > 1e-3)
    assert steering(s1, s2)[small].min() > 4


@pytest.mark.parametrize("example", ["1", "2"])
def test_an_error_of_the_input_drives_the_estimate_while_J_stays(example: str) -> None:
    """With A and C right the error obeys ε̇ = Fε − T ΔB u alone; from v to e_u that is a transfer function written out here."""
    right = {name: 0.0 for name in ("a1", "a2", "c", "b1", "b2", "d")}
    plain, wrong = (LESSON.compute(LESSON.apply(LESSON.start(), {"example": example, **right, "input": share})) for share in (0.0, 0.3))
    assert plain.metrics["J"] == wrong.metrics["J"] and plain.metrics["late_error"] < 0.1 * wrong.metrics["late_error"]
    o = wrong.study.observer
    A, B, n, q = o.plant.A, o.plant.B, o.plant.n, o.order
    # (x, ε) with u = −Kx − e + v and e = û's error: û = N z + M y = K x + N ε
    K, N = o.K, o.N
    loop = np.block([[A - 1.3 * B @ K, -1.3 * B @ N], [0.3 * o.T @ B @ K, o.F + 0.3 * o.T @ B @ N]])
    drive = np.vstack([1.3 * B, -0.3 * o.T @ B])
    gain = np.abs(np.hstack([np.zeros((1, n)), N]) @ np.linalg.solve(5j * np.eye(n + q) - loop, drive + 0j))[0, 0]
    assert np.isclose(4 * gain, wrong.study.true.loop.steady(), rtol=1e-9) and wrong.study.true.loop.steady() > 0
    assert np.allclose(np.sort_complex(np.linalg.eigvals(loop)), np.sort_complex(wrong.poles["loop"]))


def test_each_direction_of_A_has_its_own_weight() -> None:
    """Example 1: T A₁ and T A₂ have both the size |s|, so α₂ = 0 leaves half of that part."""
    for second, size in ((1.0, 10.0), (0.0, 5.0), (3.0, 20.0)):
        out = LESSON.compute(LESSON.apply(LESSON.start(), {"second": second}))
        assert np.isclose(out.metrics["J"], size + 8 + 100) and np.isclose(criterion_1(np.array([-5.0]), out.design).sum(), size + 108)


@pytest.mark.parametrize("moved", [{"pole": (-5 / 3 + 0j,)}, {"pole": (-2.03 + 0j,)}, {"example": "2", "pair": (-1.21 + 0j, -3.37 + 0j)},
                                   {"example": "2", "pair": (-1.21 - 0.5j, -1.21 + 0.5j)}])
def test_the_circles_of_the_poles_stand_on_the_curves_of_the_criterion(moved: dict[str, object]) -> None:
    out = LESSON.compute(LESSON.apply(LESSON.start(), moved))
    drawn = next(f for f in LESSON.figures(out) if f.id == "criterion")
    for pole in out.design["pair" if "pair" in moved else "pole"]:
        at = [curve.y[curve.x == pole.real] for curve in drawn.curves if len(curve.x) > 2]
        assert any(np.isclose(y, out.metrics["J"], rtol=1e-9).any() for y in at), f"J is {out.metrics['J']}, the curves are {at}"
    assert "pair" in moved or drawn.curves[0].y.min() == pytest.approx(38 / 9, rel=1e-9)
