"""Lesson 7: what clipping takes from the loop, what an honest wire gives back, and the map of starts."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from lesson_checks import by_knobs
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from observer_lab.course.lesson import Design, Outcome
from observer_lab.course.scenes import Choose, entry_values
from observer_lab.engine import Plant, Scenario, autonomous_error, observer_gain, place, simulate
from observer_lab.engine.simulation import simulate_recovery
from observer_lab.lessons.saturation import job
from observer_lab.lessons.saturation.ending import ending_of
from observer_lab.lessons.saturation.job import JOB, map_scenario
from observer_lab.lessons.saturation.lesson import LESSON
from observer_lab.lessons.saturation.study import (
    CART,
    CART_PLANT,
    FALLEN,
    LOST_NORM,
    NOT_COMPUTED,
    RECOVERED,
    RECOVERED_NORM,
    START_GRID_DEG,
    UNRECOVERABLE,
    ceiling,
    march,
    nearest,
    scenario_of,
)
from observer_lab.lessons.saturation.tasks import FAST_POLES
from observer_lab.plants.cart_pendulum import PIVOT


def design(**changes: object) -> Design:
    return LESSON.apply(LESSON.start(), changes)


def mapped(**changes: object) -> Outcome:
    *_, (fraction, outcome) = JOB.outcomes(LESSON.compute(design(**changes)))
    assert fraction == 1.0
    return outcome


@pytest.fixture(scope="module")
def told_truth() -> Outcome:
    return mapped(fed="applied")


@pytest.fixture(scope="module")
def fast_observer() -> Outcome:
    return mapped(fed="applied", observer_poles=FAST_POLES)


@pytest.fixture(scope="module")
def told_wish() -> Outcome:
    return mapped(fed="commanded")


# --- published: tutorial 000 ---------------------------------------------------------------------------------------
@pytest.mark.parametrize(("fed", "low", "high"), [("applied", 0.0, 1e-9), ("commanded", 7.65, 7.8)])
def test_double_integrator_of_the_tutorial_loses_its_error_law_only_when_fed_the_wish(fed, low, high) -> None:
    """K at −2, −2, L at −6, −6, |u| ≤ 1, 10 s; the start (5, 0), unnamed in the source, gives its 7.7."""
    plant = Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    K, L = place(plant.A, plant.B, [-2, -2]).gain, observer_gain(plant.A, plant.C, [-6, -6]).gain
    run = simulate(Scenario(plant, K, L, x0=[5, 0], xhat0=[0, 0], u_min=-1, u_max=1, fed=fed, horizon=10))
    promised = np.array([expm((plant.A - L @ plant.C) * t) @ [5, 0] for t in run.t])
    assert run.saturated
    assert low <= np.abs(run.e - promised).max() <= high


# --- the error -----------------------------------------------------------------------------------------------------
def test_told_the_truth_the_error_is_the_matrix_exponential_although_clipped() -> None:
    outcome = LESSON.compute(design(fed="applied"))
    run, L = outcome.run, outcome.gains["L"]
    promised = np.array([expm((CART_PLANT.A - L @ CART_PLANT.C) * t) @ run.e[0] for t in run.t])
    assert outcome.metrics["clipped_for"] > 0.1
    assert np.abs(run.e - promised).max() < 1e-9 * np.linalg.norm(run.e, axis=1).max()
    assert {check.id: check.holds for check in outcome.checks} == {"autonomous": True, "windup": True, "home": True}


def test_told_the_wish_the_error_is_driven_by_what_the_motor_did_not_give() -> None:
    outcome = LESSON.compute(design(fed="commanded"))
    K, L = outcome.gains["K"], outcome.gains["L"]
    run = outcome.run

    def error_rate(t: float, z: np.ndarray) -> np.ndarray:
        x, e = z[:4], z[4:]
        u = -K @ (x - e)
        given = np.clip(u, -4, 4)
        return np.concatenate([CART_PLANT.A @ x + CART_PLANT.B @ given, (CART_PLANT.A - L @ CART_PLANT.C) @ e + CART_PLANT.B @ (given - u)])

    k = 15  # 0.3 s
    peer = solve_ivp(error_rate, (0, run.t[k]), [*run.x[0], *run.e[0]], rtol=1e-10, atol=1e-12, max_step=1e-3)
    assert np.abs(peer.y[4:, -1] - run.e[k]).max() < 1e-5 * np.abs(run.e[k]).max()
    assert np.abs(run.e[k] - autonomous_error(run)[k]).max() > 0.5
    assert outcome.metrics["separation_meter"] > 1


def test_a_true_first_estimate_does_not_help_the_observer_told_the_wish() -> None:
    wish, truth = (LESSON.compute(design(fed=fed, error0=0.0)) for fed in ("commanded", "applied"))
    assert not ending_of(wish.run).home and ending_of(truth.run).home
    assert np.abs(truth.run.e).max() < 1e-10 < 1 < np.abs(wish.run.e).max()


def test_windup_is_an_eigenvalue_and_the_applied_force_removes_it() -> None:
    wish, truth = (LESSON.compute(design(fed=fed)) for fed in ("commanded", "applied"))
    K, L = wish.gains["K"], wish.gains["L"]
    assert wish.metrics["clipped_rate"] == pytest.approx(max(np.roots(np.poly(CART_PLANT.A - CART_PLANT.B @ K - L @ CART_PLANT.C)).real))
    assert wish.metrics["clipped_rate"] == pytest.approx(46.5, abs=0.05)
    assert truth.metrics["clipped_rate"] == pytest.approx(-8.0)


# --- limits --------------------------------------------------------------------------------------------------------
def test_ceiling_of_a_plain_pendulum_is_the_angle_where_gravity_wins() -> None:
    pendulum = Plant([[0, 9.0], [1, 0]], [[-2.0], [0]], [[0, 1]])  # state (ω, θ): ω̇ = 9 θ − 2 u
    assert ceiling(pendulum, 1.5) == pytest.approx(np.degrees(2 * 1.5 / 9))
    assert ceiling(CART_PLANT, 1.0) == pytest.approx(4.75, abs=0.005)


def test_beyond_the_ceiling_not_even_a_known_state_recovers() -> None:
    limit = np.radians(ceiling(CART_PLANT, 4.0))
    K = LESSON.compute(design()).gains["K"]
    s = Scenario(CART_PLANT, K, u_min=-4, u_max=4, state_feedback=True, horizon=8)
    *_, (_, found) = simulate_recovery(s, 1, [-1.3 * limit, -1.001 * limit, 0.3 * limit, 1.001 * limit], 1, [0.0],
                                  threshold=RECOVERED_NORM, bound=LOST_NORM)
    assert found.recovered.ravel().tolist() == [False, False, True, False]


def test_twice_the_limit_is_twice_the_map() -> None:
    one = LESSON.compute(design(fed="applied", u_max=2.0, angle0=3.0, error0=2.0))
    two = LESSON.compute(design(fed="applied", u_max=4.0, angle0=6.0, error0=4.0))
    assert one.metrics["clipped_for"] == two.metrics["clipped_for"] > 0
    assert np.allclose(two.run.x, 2 * one.run.x, atol=1e-9)


# --- the map -------------------------------------------------------------------------------------------------------
@pytest.mark.slow
def test_interlaced_mirrored_map_is_the_map_of_plain_runs(told_truth: Outcome) -> None:
    starts = told_truth.study.starts
    coarse = np.arange(0, len(START_GRID_DEG), 4)
    s = map_scenario(CART, scenario_of(CART, told_truth.design, told_truth.gains["K"], told_truth.gains["L"]))
    *_, (_, plain) = simulate_recovery(
        s, 1, np.radians(START_GRID_DEG[coarse]), 1, np.radians(START_GRID_DEG[coarse]), threshold=RECOVERED_NORM, bound=LOST_NORM
    )
    assert np.array_equal(starts.values[np.ix_(coarse, coarse)] == RECOVERED, plain.recovered.T)
    assert np.all((starts.values == UNRECOVERABLE).any(axis=0) == (np.abs(START_GRID_DEG) >= told_truth.metrics["ceiling"]))


@pytest.mark.slow
def test_numbers_in_the_text_are_those_of_the_maps(told_wish, told_truth, fast_observer) -> None:
    assert told_wish.metrics["map_home"] == pytest.approx(0.042, abs=0.003)
    assert told_truth.metrics["map_home"] == pytest.approx(0.280, abs=0.003)
    assert fast_observer.metrics["map_home"] == pytest.approx(0.39, abs=0.005)


@pytest.mark.slow
def test_with_a_true_estimate_the_observer_does_not_matter_and_otherwise_it_does(told_truth, fast_observer) -> None:
    one, other = told_truth.study.starts.values, fast_observer.study.starts.values
    middle = len(START_GRID_DEG) // 2
    assert START_GRID_DEG[middle] == 0 and np.array_equal(one[middle], other[middle])
    assert np.sum(one != other) > 100
    known = LESSON.compute(design(fed="applied", error0=0.0))
    home = march(replace(scenario_of(CART, known.design, known.gains["K"], known.gains["L"]), state_feedback=True))
    assert ending_of(home).home == (one[middle, int(np.flatnonzero(START_GRID_DEG == 6.0)[0])] == RECOVERED)


@pytest.mark.slow
def test_a_clicked_start_runs_as_the_map_says(told_wish, told_truth) -> None:
    rng = np.random.default_rng(7)
    for outcome in (told_wish, told_truth):
        for x, y in rng.uniform(-15, 15, (25, 2)):
            picked = LESSON.apply(outcome.design, LESSON.pick(outcome, x, y))
            assert abs(picked["angle0"] - x) <= 0.5 and abs(picked["error0"] - y) <= 0.5
            cell = outcome.study.starts.values[tuple(nearest(picked[name], START_GRID_DEG) for name in ("error0", "angle0"))]
            assert bool(LESSON.compute(picked).metrics["comes_home"]) == (cell == RECOVERED)


def test_click_outside_lands_on_the_edge_and_removes_the_kick(told_wish: Outcome) -> None:
    kicked = LESSON.compute(design(kick=2.0))
    assert LESSON.pick(kicked, 99.0, -99.0) == {"angle0": 20.0, "error0": -20.0, "kick": -1.0, "pull": (), "pull_2": ()}


def test_a_map_so_far_holds_only_final_verdicts(told_wish: Outcome) -> None:
    final = told_wish.study.starts.values
    seen, last, found = [], 0.0, {}
    for fraction, outcome in JOB.outcomes(LESSON.compute(told_wish.design)):
        assert last <= fraction <= 1.0
        last = fraction
        if outcome.study.starts is not None:
            known = outcome.study.starts.values != NOT_COMPUTED
            assert np.array_equal(outcome.study.starts.values[known], final[known])
            seen.append(float(np.mean(known)))
            found[id(outcome)] = outcome  # held, so that no other takes its place
    assert len(set(seen)) >= 4 and seen == sorted(seen) and seen[-1] == 1.0
    assert len(found) == len(set(seen)), "nothing is drawn anew that is no other"


@pytest.mark.slow
def test_the_map_goes_along_with_a_new_start_and_with_nothing_else(told_truth: Outcome) -> None:
    moved = LESSON.compute(design(fed="applied", angle0=-3.0, error0=1.0, kick=1.0))
    assert JOB.key(moved.design) == JOB.key(told_truth.design)
    assert JOB.shown(moved, told_truth.study.starts).study.starts is told_truth.study.starts
    for change in ({"fed": "commanded"}, {"u_max": 5.0}, {"observer_poles": FAST_POLES}, {"controller_poles": (-2, -2.5, -3, -4)}):
        other = LESSON.compute(LESSON.apply(told_truth.design, change))
        assert JOB.key(other.design) != JOB.key(told_truth.design)
        assert np.all(LESSON.figures(other)[-1].values == NOT_COMPUTED)


@pytest.mark.slow
def test_a_dropped_job_goes_on_where_it_was(told_wish: Outcome) -> None:
    def parts(job: Iterator[tuple[float, Outcome]]) -> Iterator[Outcome]:
        return (outcome for _, outcome in job if outcome.study.starts is not None)

    half = next(o for o in parts(JOB.outcomes(LESSON.compute(told_wish.design))) if o.study.starts.done > 0.5)
    moved = JOB.shown(LESSON.compute(LESSON.apply(told_wish.design, {"angle0": 1.0})), half.study.starts)
    assert 0.5 < moved.study.starts.done < 1
    first, *_ = rest = list(JOB.outcomes(moved))
    assert first[0] > 0.5 and first[1].study.starts.done >= moved.study.starts.done
    assert np.array_equal(rest[-1][1].study.starts.values, told_wish.study.starts.values)


@pytest.mark.slow
def test_a_rough_map_is_right_wherever_it_was_run_and_gives_no_numbers(
        monkeypatch: pytest.MonkeyPatch, told_wish: Outcome, told_truth: Outcome) -> None:
    monkeypatch.setattr(job, "kernels_ready", lambda: True)
    for whole in (told_wish, told_truth):
        rough, full = job.rough_starts(LESSON.compute(whole.design)), whole.study.starts.values
        at = np.ix_(job.COARSE, job.COARSE)
        assert np.array_equal(rough.values[at], full[at]) and np.array_equal(rough.values == UNRECOVERABLE, full == UNRECOVERABLE)
        assert np.mean(rough.values == full) > 0.95
        drawn = JOB.shown(LESSON.compute(whole.design), rough)
        assert "map_home" not in drawn.metrics
        _, began = next(JOB.outcomes(drawn))
        assert not began.study.starts.rough and began.study.starts.done < 0.5, "the whole map begins anew"


def test_there_is_no_rough_map_where_no_start_comes_home_or_runs_are_not_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job, "kernels_ready", lambda: True)
    assert job.rough_starts(LESSON.compute(design(observer_poles=(1, -8, -9, -10)))) is None
    monkeypatch.setattr(job, "kernels_ready", lambda: False)
    assert job.rough_starts(LESSON.compute(design())) is None


def test_unstable_poles_have_no_map_but_a_sentence() -> None:
    with pytest.raises(ValueError, match="left half plane"):
        next(JOB.outcomes(LESSON.compute(design(observer_poles=(1, -8, -9, -10)))))


# --- runs, tasks, exam ---------------------------------------------------------------------------------------------
@pytest.mark.parametrize("kick", [-1.0, 0.0, 0.5, 1.37, 4.0, 8.0])
def test_a_run_in_parts_is_the_run_in_one(kick: float) -> None:
    outcome = LESSON.compute(design(fed="applied", kick=kick))
    s = scenario_of(CART, outcome.design, outcome.gains["K"], outcome.gains["L"])
    parts, one = march(s), simulate(s)
    assert len(parts.t) == len(one.t) == s.n_t
    assert np.abs(parts.x - one.x).max() < 1e-9 and np.abs(parts.u_applied - one.u_applied).max() < 1e-7


def test_a_fallen_pole_is_shown_at_its_fall_for_the_rest_of_the_time() -> None:
    outcome = LESSON.compute(design(fed="commanded"))
    shown, stopped = outcome.study.shown, outcome.study.stopped
    after = shown.t >= stopped
    assert len(shown.t) == 401 and 0.5 < stopped < 1.0
    assert np.all(np.abs(shown.x[after, 1]) > FALLEN) and np.all(np.abs(shown.x[~after, 1]) <= FALLEN)
    assert np.ptp(shown.x[after], axis=0).max() == 0
    assert outcome.run.t[-1] < stopped


@pytest.mark.parametrize("task", by_knobs(LESSON.tasks), ids=lambda task: task.id)
def test_task_fails_at_the_start_and_passes_at_its_solution(task) -> None:
    assert not task.check(LESSON.compute(LESSON.start())).solved
    assert task.check(LESSON.compute(LESSON.apply(LESSON.start(), task.solution))).solved


def test_told_the_truth_is_needed_in_every_task_in_which_something_is_clipped() -> None:
    for task in by_knobs(LESSON.tasks):
        truthful = LESSON.compute(LESSON.apply(LESSON.start(), task.solution))
        lied = LESSON.apply(LESSON.start(), {**task.solution, "fed": "commanded"})
        assert task.check(LESSON.compute(lied)).solved == (truthful.metrics["clipped_for"] == 0) == (task.id == "never-clipped")


def test_what_is_drawn_at_the_edge_is_said_so_and_what_fits_is_not():
    lost = {f.id: f for f in LESSON.figures(LESSON.compute(design()))}
    assert max(abs(lost["state0"].curves[1].y)) == 49.0
    assert "edge" in lost["state0"].caption("en") and "边缘" in lost["state0"].caption("zh")
    calm = {f.id: f for f in LESSON.figures(LESSON.compute(design(fed="applied")))}
    assert not any("edge" in f.caption("en") for f in calm.values())


# --- sentences -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("fed", ["commanded", "applied"])
@pytest.mark.parametrize("start", [{"angle0": 0.5, "error0": 0.0}, {"angle0": 6.0, "error0": 4.0}, {"angle0": 3.0, "error0": 0.0}])
@pytest.mark.parametrize("u_max", [1.0, 4.0, 10.0])
def test_clipped_and_promise_are_said_of_a_force_that_was_clipped(fed: str, start: dict[str, float], u_max: float) -> None:
    o = LESSON.compute(design(fed=fed, u_max=u_max, **start))
    clipped = bool(np.any(np.abs(o.run.u_asked) > u_max * (1 + 1e-9)))
    caption = next(f for f in LESSON.figures(o) if f.id == "error").caption("en")
    assert ("all the same" in o.live("en")) == (clipped and fed == "applied")
    assert ("never clipped" in o.live("en")) == ("Nothing is clipped" in caption) == (not clipped)
    assert ("is clipped, and the error still follows" in caption) == (clipped and fed == "applied")


def test_a_start_lost_by_an_unstable_observer_is_not_lost_by_belief() -> None:
    task = next(t for t in LESSON.tasks if t.id == "lost-by-belief")
    assert task.check(LESSON.compute(LESSON.apply(LESSON.start(), task.solution))).solved
    for fed in ("commanded", "applied"):
        assert not task.check(LESSON.compute(design(fed=fed, observer_poles=(1, -8, -9, -10)))).solved


def test_a_hand_goes_on_pulling_where_the_estimate_has_left_all_bounds() -> None:
    """The time of the fall, by scipy's integrator with every push of the hand."""
    from verdict_saturation import told_of

    lesson = LESSON
    for force in (-8.0, 5.0):
        design = lesson.apply(lesson.start(), {"error0": -20.0, "observer_poles": (-16.0, -15.84, -15.68, -15.52),
                                               "pull_2": ((0.0, force),)})
        outcome = lesson.compute(design)
        told = told_of(outcome.run.scenario, 1, False)
        assert np.isfinite(told.fell) and abs(outcome.metrics["stopped_at"] - told.fell) < 0.03


@pytest.mark.parametrize("limit", [1e-7, 1e-9, 1e-12, 1e-15])
def test_a_loop_that_a_small_limit_holds_close_to_rest_does_not_recover(limit: float) -> None:
    """ẋ = −x + u with u = sat(2x) ends at ±limit, however small that is beside the start."""
    plant = Plant(np.array([[-1.0]]), np.array([[1.0]]), np.array([[1.0]]), np.array([[0.0]]))
    for known in (False, True):
        end = ending_of(simulate(Scenario(plant, np.array([[-2.0]]), np.array([[1.0]]), x0=(1.0,), xhat0=(1.0,), horizon=40.0, dt=0.05,
                                          u_min=-limit, u_max=limit, fed="applied", state_feedback=known)))
        assert end.decided and not end.home and end.unstable


def test_fog_hides_the_pole_and_nothing_else_of_a_run() -> None:
    clear, fog = (LESSON.compute(design(fog=each, pull=((0.0, 0.1),))) for each in (False, True))
    assert clear.stage is not None and fog.stage is not None
    np.testing.assert_array_equal(clear.stage.x, fog.stage.x)
    assert {part.name for part in fog.stage.body.parts if part.unseen} == {"pole", "ball"} and clear.metrics == fog.metrics
    assert not any(part.unseen for part in clear.stage.body.parts)
    assert [grip.knob for grip, _ in clear.stage.held] == ["pull", "pull_2"] and [grip.knob for grip, _ in fog.stage.held] == ["pull_2"]
    state = fog.stage.x[0].tolist()
    assert all(z < PIVOT for *_, z in fog.stage.body.anchors(state, 1.0)), "no line leads to the hidden pole"
    angle, position = (next(f for f in LESSON.figures(fog) if f.id == id) for id in ("state0", "state1"))
    assert [curve.role for curve in angle.curves] == ["estimate"] and len(position.curves) == 2
    np.testing.assert_allclose(angle.curves[0].y, np.clip(np.degrees(fog.stage.xhat[:, 1]), -49, 49))


def test_the_hidden_pole_of_the_path_comes_upright_with_its_estimate_and_would_fall_without_a_force() -> None:
    """By scipy's integrator, from where the scene starts."""
    from verdict_saturation import told_of

    scene = next(scene for scene in LESSON.path if scene.id == "fog")
    values = entry_values(LESSON.path, LESSON.path.index(scene), LESSON.start())
    assert values["fog"] and scene.play == {"fog": False} and isinstance(scene.do, Choose) and scene.do.answer == 1
    outcome = LESSON.compute(design(**values))
    told = told_of(outcome.run.scenario, 1, False)
    assert told.rest and not told.clipped and outcome.run.xhat[0, 1] == 0.0
    free = solve_ivp(lambda _, x: CART_PLANT.A @ x, (0, 1.5), outcome.run.x[0], rtol=1e-9, atol=1e-12)
    assert free.y[1, -1] > FALLEN
    assert np.abs(outcome.run.e[-1]).max() < 1e-9 and np.abs(np.degrees(outcome.run.x[-1, 1])) < 0.5


def test_the_angle_has_lines_at_the_largest_angle_that_any_controller_recovers_from_rest() -> None:
    """They stand to both sides and move with the force limit; the largest limit keeps them within the figure."""
    for limit in (1.0, 4.0, 10.0):
        outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"u_max": limit}))
        angle = next(figure for figure in LESSON.figures(outcome) if figure.id == "state0")
        lines = [curve.y[0] for curve in angle.curves if curve.name("en") == "limit from rest"]
        ceiling = outcome.metrics["ceiling"]
        assert lines == pytest.approx([-ceiling, ceiling]) and ceiling < 49.0


def test_the_stage_draws_the_asked_force_beyond_the_applied_one_only_where_the_motor_clips() -> None:
    outcome = LESSON.compute(design(fed="commanded"))
    stage, limit = outcome.stage, design(fed="commanded")["u_max"]
    assert stage is not None and stage.u is not None
    asked = -(outcome.study.shown.xhat @ outcome.gains["K"].T)[:, 0]  # the control law, not the run's own record
    clipped = np.abs(asked) > limit * 1.01
    assert clipped.any() and not clipped.all()
    for index in np.flatnonzero(np.abs(asked) > 0.2)[::7]:
        acts, wanted = stage.body.arrows(stage.x[index].tolist(), stage.u[index].tolist(), stage.body.gain)
        lengths = [each.head[0] - each.tail[0] for each in (acts, wanted)]
        assert (acts.role, wanted.role) == ("force", "asked") and wanted.tail[2] > acts.tail[2]
        if stage.t[index] < outcome.study.stopped:
            assert (abs(lengths[1]) > abs(lengths[0]) + 1e-9) == (abs(asked[index]) > limit * (1 + 1e-9))
