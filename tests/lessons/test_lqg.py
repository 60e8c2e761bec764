"""The lesson on LQG: what its text says, on the engine; Doyle's plant against its closed forms; any model that fits."""

from itertools import pairwise

import control
import numpy as np
import pytest
from lesson_checks import carried
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov
from scipy.optimize import brentq
from witnesses import Shown
from witnesses_of_variances import least_cost

from observer_lab.course.figures.records import Curve, LineFigure
from observer_lab.course.lesson import Outcome
from observer_lab.engine import EngineError, compensator, loop_margins, lqg, recover
from observer_lab.engine.feedback import state_feedback_margins
from observer_lab.lessons.lqg.cases import case_of
from observer_lab.lessons.lqg.job import bench_of
from observer_lab.lessons.lqg.lesson import LESSON
from observer_lab.lessons.lqg.loop_figures import RING_NAME, RING_RECOVERIES
from observer_lab.lessons.lqg.loops import setting_of, trace
from observer_lab.lessons.lqg.own import adapted
from observer_lab.lessons.toolkit.figures import within
from observer_lab.plants import MODELS, doyle
from observer_lab.text import same


def at(**values: object) -> Outcome:
    return LESSON.compute(LESSON.apply(LESSON.start(), values))


# --- Doyle 1978 --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("q, sigma", [(1.0, 1.0), (5.0, 21.0), (60.0, 5.0), (1000.0, 1000.0), (1e4, 1e4)])
def test_doyles_gains_and_the_edge_of_stability_are_his_closed_forms(q: float, sigma: float) -> None:
    p, one = doyle.plant(), doyle.BOTH_STATES
    d = lqg(p, q * one @ one.T, 1.0, sigma, 1.0, G=one)
    f, dd = doyle.gains(q, sigma)
    assert pytest.approx(np.full((1, 2), f), rel=1e-9) == d.K
    assert pytest.approx(np.full((2, 1), dd), rel=1e-9) == d.L
    edge = 1 + 1 / (dd * f)
    assert doyle.largest_gain(q, sigma) == pytest.approx(edge)
    for m, stable in ((edge * (1 - 1e-7), True), (edge * (1 + 1e-7), False)):
        A = np.block([[p.A, -m * p.B @ d.K], [d.L @ p.C, p.A - p.B @ d.K - d.L @ p.C]])
        assert bool(np.linalg.eigvals(A).real.max() < 0) is stable
    assert loop_margins(p, d.controller).inputs[0].gain[1] == pytest.approx(edge, rel=1e-8)


def test_the_margins_vanish_as_the_knobs_grow_and_recovery_brings_them_back() -> None:
    sizes = (1.0, 10.0, 100.0, 1000.0, 1e4)
    high = [at(case="doyle", q=s, sigma=s).study.real.margins.gain[1] for s in sizes]
    assert all(a > b for a, b in pairwise(high)) and high[-1] < 1.0001
    near = [at(case="doyle", q=1000.0, sigma=1000.0, recovery=r).metrics["nearest"] for r in (0.0, 2.0, 4.0, 6.0, 8.0, 10.0)]
    assert all(a < b for a, b in pairwise(near)) and near[0] < 1e-3 and near[-1] > 0.95


def loop_by_hand(q: float, sigma: float, rho: float, omega: np.ndarray) -> np.ndarray:
    """Doyle's loop cut at the input, from scipy's Riccati solver and the recovery noise μ² = (10^ρ − 1) tr(GWGᵀ)/tr(BBᵀ)."""
    A, B, C, one = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]), np.ones((2, 2))
    K = B.T @ solve_continuous_are(A, B, q * one, np.eye(1))
    W = sigma * one + (10.0**rho - 1) * 2 * sigma * B @ B.T
    L = solve_continuous_are(A.T, C.T, W, np.eye(1)) @ C.T
    controller = control.ss(A - B @ K - L @ C, L, K, 0)
    return np.squeeze((controller * control.ss(A, B, C, 0))(1j * omega))


@pytest.mark.parametrize(("q", "sigma"), [(5.0, 5.0), (1000.0, 1000.0), (0.5, 60.0)])
def test_the_rings_are_the_loops_from_plain_lqg_to_lqr(q: float, sigma: float) -> None:
    """Each one at its point nearest to −1, which comes no nearer the more is recovered."""
    omega = np.concatenate([[0.0], np.geomspace(1e-4, 1e5, 40_000)])
    figure = next(f for f in LESSON.figures(at(case="doyle", q=q, sigma=sigma, recovery=4.0)) if f.id == "rings")
    drawn = {c.name("en"): c.x + 1j * c.y for c in figure.curves}
    curves = {rho: loop_by_hand(q, sigma, rho, omega) for rho in (0.0, *RING_RECOVERIES)}
    near = {rho: ell[np.argmin(np.abs(1 + ell))] for rho, ell in curves.items()}
    assert all(abs(1 + a) < abs(1 + b) < 1 for a, b in pairwise(near.values())) and np.abs(1 + drawn["LQR"]).min() > 1 - 1e-6
    for name, steps in (("plain LQG", (0.0,)), ("this LQG", (4.0,)), (RING_NAME, RING_RECOVERIES)):
        for rho in steps:
            gaps = np.abs(drawn[name] - near[rho])
            assert gaps.min() < 0.02 * abs(1 + near[rho]) + 0.01, (name, rho)


def test_lqr_keeps_its_margins_on_both_plants() -> None:
    for values in ({"case": "doyle", "q": 1000.0}, {"case": "doyle"}, {}, {"alpha_q": 1e-2}):
        m = at(**values).study.ideal.margins
        assert m.nearest > 1 - 1e-6 and m.gain[0] <= 0.5 and m.gain[1] == np.inf and np.degrees(m.phase) >= 60


def test_the_lessons_recovery_is_the_engines() -> None:
    one, p = doyle.BOTH_STATES, doyle.plant()
    outcome = at(case="doyle", q=60.0, sigma=60.0, recovery=3.0)
    unit = np.trace(one @ one.T) / np.trace(p.B @ p.B.T)
    found = recover(p, outcome.gains["K"], 60.0, 1.0, float(np.sqrt((10**3 - 1) * unit * 60.0)), G=one)
    assert outcome.gains["L"] == pytest.approx(found.gain_L, rel=1e-9)


def test_a_gain_beyond_the_edge_departs_and_one_within_returns() -> None:
    for m, home in ((1.03, True), (1.05, False)):
        outcome = at(case="doyle", gain=m)  # q = σ = 5: the edge is 1.04
        assert (outcome.study.density is not None) is home
        assert bool(outcome.poles["loop"].real.max() < 0) is home


# --- the platform ------------------------------------------------------------------------------------------------------
# V of the report: suppression in dB by the table that was made before this lesson
TABLE = {1e-18: (110, 96, 113), 1e-12: (61, 61, 57), 1e-10: (41, 26, 37), 1e-9: (31, 11, 27), 1e-8: (21, 3, 17), 1e-6: (3.6, 0, 1.8)}


@pytest.mark.parametrize("V", TABLE)
def test_the_lessons_suppression_is_that_of_the_table(V: float) -> None:
    outcome = at(beta_r=V / 1e-18)
    assert outcome.study.suppression == pytest.approx(np.array(TABLE[V]), abs=0.8)


def test_the_numbers_in_the_text() -> None:
    start, literal = at(), at(beta_r=1.0)
    assert start.study.suppression == pytest.approx(np.array([31.2, 11.0, 27.2]), abs=0.1)
    assert start.study.low[1] == pytest.approx(-31.1, abs=0.3)  # pitch is amplified at 0.1 Hz
    assert start.study.low[[0, 2]] == pytest.approx(np.zeros(2), abs=0.1)
    assert start.metrics["J_known"] == pytest.approx(0.0114, abs=5e-5)
    assert start.metrics["J"] == pytest.approx(904, abs=1) and literal.metrics["J"] == pytest.approx(0.0690, abs=1e-4)
    assert literal.metrics["J"] == pytest.approx(literal.metrics["J_least"], rel=1e-6)
    assert at(beta_r=1.0, cut="3").metrics["delay"] == pytest.approx(30e-6, rel=0.03)
    assert at(cut="3").metrics["delay"] == pytest.approx(0.21, abs=0.01)
    assert start.metrics["all_inputs_nearest"] == pytest.approx(0.34, abs=0.005)
    assert all(at(cut=c).metrics["nearest"] > 0.99 for c in "123")
    twenty = at(beta_r=1e8, cut="3")
    assert twenty.study.suppression == pytest.approx(np.array([41.2, 25.5, 37.1]), abs=0.1)
    assert twenty.metrics["delay"] == pytest.approx(0.163, abs=0.002)


def test_a_lqg_that_trusts_its_model_more_lets_less_noise_into_the_input() -> None:
    """Rule 2 of the report says the reverse."""
    for sensor in (1.0, 1e9):
        rms = [at(beta_r=b, sensor=sensor).metrics["sensor_input"] for b in (1e0, 1e3, 1e6, 1e9, 1e12)]
        assert all(a > 2 * b for a, b in pairwise(rms))
    evidence = at(rule="beta-r").metrics
    assert evidence["sensor_less"] > 2 and evidence["sensor_more"] == pytest.approx(0.287, abs=0.005)


def test_the_other_rules_hold() -> None:
    assert at(rule="split").metrics["union_error"] < 1e-9
    assert at(rule="beta-q").metrics["process_more"] > 1.2


def test_recovery_makes_the_filter_watch_the_pitch_that_the_ground_hardly_moves() -> None:
    before, after = at(), at(recovery=1.0)
    assert before.study.suppression[1] == pytest.approx(11.0, abs=0.1) and after.study.suppression[1] == pytest.approx(21.2, abs=0.1)
    assert before.metrics["all_inputs_nearest"] == pytest.approx(0.34, abs=0.01)
    assert after.metrics["all_inputs_nearest"] == pytest.approx(0.98, abs=0.01)


def test_the_multivariable_numbers_are_the_engines() -> None:
    o = at()
    p = o.study.case.plant
    both = loop_margins(p, compensator(p, o.gains["K"], o.gains["L"])).all_inputs
    assert o.study.real.nearest == pytest.approx(1 / both.sensitivity_peak, rel=2e-3)
    assert o.study.real.alpha == pytest.approx(both.unstructured.alpha, rel=2e-3)
    ideal = state_feedback_margins(p, o.gains["K"]).all_inputs
    assert o.study.ideal.nearest == pytest.approx(1 / ideal.sensitivity_peak, rel=1e-6)


def test_the_believed_noise_being_true_no_other_filter_is_cheaper() -> None:
    matched = at(beta_r=1e3, sensor=1e3)
    assert matched.metrics["J"] == pytest.approx(matched.metrics["J_least"], rel=1e-6)
    for beta in (1e2, 1e4):
        assert at(beta_r=beta, sensor=1e3).metrics["J"] > 1.01 * matched.metrics["J"]


def test_a_controller_that_is_told_the_true_gain_is_the_least_in_cost() -> None:
    for values in ({"beta_r": 1.0, "gain": 1.2}, {"beta_r": 1.0, "gain": 0.8}, {"case": "doyle", "gain": 1.03}):
        o = at(**values)
        least = least_cost(Shown(LESSON, o, None))
        assert o.metrics["J_least"] == pytest.approx(least, rel=1e-5) and o.metrics["J"] > 1.001 * least > o.metrics["J_known"]
        assert "not what the model says" in str(next(f for f in LESSON.figures(o) if f.id == "cost").caption)


def test_the_recursive_filter_finds_the_state_long_before_the_steady_one() -> None:
    """In the run, whose first error the recursive filter's P(0) knows."""
    steady, recursive = at(), at(filter="recursive")
    size = [o.study.trace.error(o.study.case) for o in (steady, recursive)]
    t = steady.study.trace.t
    assert size[1][t > 0.1].max() < 0.01 * size[1][0]
    assert size[0][-1] == pytest.approx(0.23 * size[0][0], rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("values", [{}, {"filter": "recursive"}, {"case": "doyle"}, {"case": "doyle", "filter": "recursive"},
                                    {"beta_r": 1e8, "sensor": 1e9, "seed": 5}])
def test_the_runs_lie_on_the_prediction(values: dict) -> None:
    start = at(**values)
    *_, (share, last) = LESSON.job.outcomes(start)  # type: ignore[union-attr]
    assert share == 1.0
    trials = last.study.trials
    assert trials.ratio == pytest.approx(np.ones(3), abs=0.08)
    assert (trials.inside > 0.85).all()  # 95 % are expected; neighbouring points are not independent
    known = carried(LESSON, last.design, trials, at(**{**values, "rule": "split"}))
    assert known.study.trials is trials
    assert carried(LESSON, last.design, trials, at(**{**values, "recovery": 1.0})).study.trials is None


def test_a_computer_at_200_hz_keeps_little_of_the_literal_design() -> None:
    for beta, kept in ((1e9, (31.1, 11.0, 27.1)), (1.0, (67.3, 81.5, 70.2))):
        o = at(beta_r=beta)
        case, f = o.study.case, o.study.case.frequency
        band = (f > 0.5) & (f < 3)
        computed = bench_of(case, setting_of(case, o.design)).loop.psd(f)
        assert 10 * np.log10(case.open_psd[band].max(axis=0) / computed[band].max(axis=0)) == pytest.approx(np.array(kept), abs=0.3)


# --- any model that fits -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", ["spring-damper", "cart-pendulum", "deck", "two-mass"])
def test_the_lesson_takes_any_model_that_fits_or_says_why_not(name: str) -> None:
    try:
        lesson = adapted(LESSON, MODELS[name])
        outcome = lesson.compute(lesson.start())
    except EngineError as problem:
        assert str(problem).endswith(".")
        return
    assert outcome.metrics["J"] == pytest.approx(outcome.metrics["J_least"], rel=1e-6)
    assert lesson.figures(outcome) and "case" not in {k.name for k in lesson.knobs}
    for change in ({"filter": "recursive"}, {"recovery": 3.0}, {"gain": 1.2}, {"rule": "beta-r"}):
        lesson.figures(lesson.compute(lesson.apply(lesson.start(), change)))


def test_a_kick_is_felt_by_both_filters() -> None:
    case = case_of(MODELS["deck"])
    lesson = adapted(LESSON, MODELS["deck"])
    setting = setting_of(case, lesson.start())
    for recursive in (False, True):
        kicked, calm = (trace(case, setting, k, recursive) for k in (1.5, -1.0))
        before = calm.t < 1.49
        assert np.allclose(kicked.x[before], calm.x[before], atol=1e-12)
        assert np.abs(kicked.x[~before] - calm.x[~before]).max() > 1e-4


def test_the_price_of_recovery_is_as_the_solution_says() -> None:
    o = at(case="doyle", q=1000.0, sigma=1000.0, recovery=6.0)
    m, s = o.study.real.margins, o.study
    assert m.gain == pytest.approx((0.0719, 5.385), rel=1e-3) and np.degrees(m.phase) == pytest.approx(75.3, abs=0.1)
    assert np.linalg.norm(s.cost.sensors) / np.linalg.norm(s.plain_cost.sensors) == pytest.approx(273, abs=1)
    assert s.cost.total > s.plain_cost.total


def test_a_run_that_leaves_every_scale_is_not_said_to_stay_within_the_picture():
    figure = LineFigure("state0", same("x"), np.arange(3.0), (Curve(same("true"), np.array([0.0, 5.0, 500.0])),), caption=same("Now."))
    held = within(figure, 40.0)
    assert held.curves[0].y.max() == 40.0 and held.caption("en") == "Now. Points beyond the scale are drawn at its edge."
    assert within(figure, 500.0) is figure


@pytest.mark.parametrize("values", [{}, {"alpha_r": 100.0}, {"beta_r": 1.0}, {"beta_r": 1.0, "sensor": 1e9}, {"case": "doyle"},
                                    {"case": "doyle", "q": 1e3, "sigma": 1e3}, {"case": "doyle", "recovery": 6.0}])
def test_a_loop_is_called_optimal_only_if_no_loop_is_cheaper(values: dict) -> None:
    o = at(**values)
    caption = next(f for f in LESSON.figures(o) if f.id == "margins").caption("en")
    claimed = "Optimal, yet" in caption or "optimality guarantees" in caption
    assert claimed == (o.metrics["J"] <= o.metrics["J_least"] * (1 + 1e-6)), caption


@pytest.mark.parametrize("values", [{}, {"beta_r": 1.0}, {"filter": "recursive"}, {"case": "doyle"}])
def test_an_error_that_is_still_large_at_the_end_is_not_said_to_have_fallen(values: dict) -> None:
    o = at(**values)
    figure = next(f for f in LESSON.figures(o) if f.id == "error")
    assert ("at the end" in figure.caption("en")) == bool(figure.curves[0].y[-1] > 0.1)


def test_only_one_rule_of_tuning_is_turned_round() -> None:
    """β_Q ↑ is about the filter: it gets faster, and passes more of the sensors' noise on; β_R ↑ passes less."""
    o = at(rule="beta-q")
    assert o.metrics["process_more"] > 1 and o.metrics["process_input"] == pytest.approx(3.2, abs=0.1)
    assert at(rule="beta-r").metrics["sensor_more"] < 1


def test_a_peak_that_has_grown_is_not_said_to_be_lowered_by_less_than_nothing() -> None:
    o = at(sensor=1e12)
    for figure, drop in zip(LESSON.figures(o), o.study.suppression, strict=False):
        assert ("raised" in str(figure.caption)) == (drop < 0) and "−" not in str(figure.caption).split(";")[0]


def test_the_lanes_on_the_stage_are_the_gains_at_which_the_loop_is_stable_and_the_ball_falls_beyond_them() -> None:
    for values, held in (({"gain": 1.039}, True), ({"gain": 1.041}, False), ({"gain": 0.914}, False), ({"gain": 2.0, "recovery": 4}, True),
                         ({"gain": 1.001, "q": 1000.0, "sigma": 1000.0}, False)):
        o = LESSON.compute(LESSON.apply(LESSON.start(), {"case": "doyle", **values}))
        assert (float(np.max(o.study.loop.poles.real)) < 0) == held and o.stage is not None
        poses = o.stage.body.pose(o.stage.x[3].tolist(), 1.0)
        lane, ball = poses["near lane"], poses["true gain"]
        assert (ball.position[2] > poses["far lane"].position[2]) == held
        assert (abs(ball.position[0] - lane.position[0]) < lane.scale[0] / 2) == held


@pytest.mark.parametrize("q, sigma", [(5.0, 5.0), (100.0, 100.0), (20.0, 300.0)])
def test_the_limits_beside_the_blue_lane_are_those_of_doyle_and_of_the_regulator_that_knows_the_state(q: float, sigma: float) -> None:
    """LQG: up to 1 + 1/(d f) in closed form, down to where an eigenvalue of the loop reaches the axis. Known state: above 2/f."""
    f, d = 2 + np.sqrt(4 + q), 2 + np.sqrt(4 + sigma)
    A, B, C = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    K, L = f * np.ones((1, 2)), d * np.ones((2, 1))

    def growth(m: float) -> float:
        return float(np.max(np.linalg.eigvals(np.block([[A, -m * B @ K], [L @ C, A - B @ K - L @ C]])).real))
    low = brentq(growth, 0.5, 0.999)
    for lane, words in (("estimate", f"−{100 * (1 - low):.2g} % … +{100 / (d * f):.2g} %"), ("state", f"{2 / f:.2g} … ∞")):
        stage = LESSON.compute(LESSON.apply(LESSON.start(), {"case": "doyle", "q": q, "sigma": sigma, "lane": lane})).stage
        assert stage is not None and stage.body.marks is not None
        x = stage.x[3].tolist()
        assert stage.body.marks(x, x, 1.0).words[0][0] == words
        poses = stage.body.pose(x, 1.0)
        near, far, pale = (poses.get(f"{name} lane") for name in ("near", "far", "pale"))
        octaves = 0.82 * np.log2(6.0 / (2 / f) if lane == "state" else (1 + 1 / (d * f)) / low)
        assert near.scale[0] == pytest.approx(max(octaves, 0.014) if lane == "estimate" else far.scale[0], rel=1e-6)
        assert pale is None if lane == "state" else pale.scale == far.scale
        assert poses["pin"].position[0] == poses["true gain"].position[0] == pytest.approx(-0.25)


@pytest.mark.parametrize("changes", [{}, {"beta_r": 1e10}, {"beta_r": 1e8, "alpha_r": 1.0}, {"alpha_r": 0.01}])
def test_the_bar_before_the_deck_is_the_input_from_sensor_noise_over_that_at_the_default_settings(changes: dict[str, float]) -> None:
    """x̂̇ = (A − BK)x̂ + L(Ce + v), ė = (A − LC)e − Lv, u = −Kx̂ with V = I: the mean square of u by one Lyapunov equation."""
    def size(o: Outcome) -> float:
        p, K, L = o.study.case.plant, o.gains["K"], o.gains["L"]
        whole = np.block([[p.A - p.B @ K, L @ p.C], [np.zeros_like(p.A), p.A - L @ p.C]])
        noise = np.vstack([L, -L])
        P = solve_continuous_lyapunov(whole, -noise @ noise.T)[:p.n, :p.n]
        return float(np.sqrt(np.trace(K @ P @ K.T)))
    first, now = (LESSON.compute(LESSON.apply(LESSON.start(), {"case": "platform", "noise_bar": True, **values}))
                  for values in ({}, changes))
    assert now.stage is not None and now.stage.body.marks is not None
    x, times = now.stage.x[0].tolist(), size(now) / size(first)
    poses = now.stage.body.pose(x, 1.0)
    assert poses["bar 0"].scale[2] == pytest.approx(3.2 * np.clip((np.log10(times) + 1) / 2, 0.004, 1), rel=1e-4)
    assert float(now.stage.body.marks(x, x, 1.0).words[0][0]) == pytest.approx(times, rel=0.05)
    assert poses["default input"].position[0] == pytest.approx(poses["bar 0"].position[0] + 0.8)
