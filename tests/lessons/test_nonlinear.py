"""Nonlinear: three filters on one flow; both reduce to the Kalman filter, and NEES tells which deceives itself."""

from functools import lru_cache

import numpy as np
import pytest
from lesson_checks import by_knobs, carried
from scipy.stats import chi2

from observer_lab.engine import chi2_band
from observer_lab.engine.filters import simulate_filters
from observer_lab.engine.systems import slopes
from observer_lab.lessons.nonlinear.cases import EKF, FALL_CASE, KF, PENDULUM_CASE, PLATFORM, UKF, case_of
from observer_lab.lessons.nonlinear.lesson import LESSON
from observer_lab.lessons.nonlinear.report_algorithms import linear_spreads
from observer_lab.lessons.nonlinear.runs import FILTERS, JOB_RUNS, Study, experiment_of, studies
from observer_lab.lessons.nonlinear.study import verdict

SEEDS = range(1, 7)
LINEAR = {"hardening": 0.0, "weakening": 0.0}


@lru_cache(maxsize=40)
def many(**values) -> Study:
    """Of a design of the platform, or of another case, the runs of the button; several laws are asked of one study."""
    design = LESSON.apply(LESSON.start(), {"case": PLATFORM, **values})
    *_, study = studies(design, JOB_RUNS, case_of(design["case"]).full, 50)
    assert study is not None
    return study


@pytest.fixture(scope="module", autouse=True)
def forgotten():
    yield
    many.cache_clear()  # megabytes each


def says(study: Study, name: str) -> str:
    return verdict(study.nees[name], study.x.shape[1], study.runs)("en")


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("more", [{}, {"steer": True, "filter": UKF}, {"alpha": 0.4, "kappa": 1.0, "beta": 0.0}])
def test_without_bends_extended_and_unscented_are_the_kalman_filter_to_rounding(seed, more):
    study = many(**LINEAR, seed=seed, **more)
    assert max(study.apart.values()) < 1e-10
    np.testing.assert_allclose(study.bound.rms, study.sigmas[KF][:, 1], rtol=1e-8)
    for name in (EKF, UKF):
        np.testing.assert_allclose(study.nees[name], study.nees[KF], rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_all_three_are_consistent_where_nothing_bends(seed):
    study = many(**LINEAR, seed=seed)
    low, high = chi2_band(6, count=JOB_RUNS, level=0.99999)
    assert ((study.nees[KF] > low) & (study.nees[KF] < high)).all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_algorithm_3_as_printed_is_not_the_kalman_filter_where_nothing_bends(seed, capsys):
    study = many(**LINEAR, seed=seed, redraw=False)
    with capsys.disabled():
        print(f"\nseed {seed}: printed UKF up to {study.apart[UKF]:.3f} σ from the KF, NEES per state "
              f"{study.ratio(UKF):.3f} against {study.ratio(KF):.3f}; EKF {study.apart[EKF]:.1e} σ")
    assert study.apart[UKF] > 0.1 and study.apart[EKF] < 1e-10
    assert study.ratio(UKF) < 0.97 * study.ratio(KF)  # it believes less than it could
    assert many(**LINEAR, seed=seed).apart[UKF] < 1e-10


def test_the_printed_gain_costs_what_the_text_says():
    right, believed, real, apart = linear_spreads(PLATFORM, 10.0, 0.1)
    assert 5.5 < real[-1] / right[-1] < 7 and apart > 0.1
    for name in (PLATFORM, PENDULUM_CASE):
        right, believed, real, apart = linear_spreads(name, 1.0, 1.0)
        assert (real >= right * (1 - 1e-12)).all() and believed[-1] > right[-1] and apart > 1e-3
    right, believed, real, apart = linear_spreads(FALL_CASE, 1.0, 1.0)  # Q = 0: nothing to redraw for
    np.testing.assert_allclose(believed, right, rtol=1e-9)
    np.testing.assert_allclose(real, right, rtol=1e-9)


@pytest.mark.parametrize("seed", range(30))
def test_on_the_falling_body_the_extended_filter_is_overconfident_and_the_unscented_is_not(seed):
    """χ²(3): 99 % of the runs belong below its 99 % point. Means: EKF ten thousandfold; UKF as it should, but for strays."""
    study = many(case=FALL_CASE, seed=seed)
    assert study.honest[UKF] > 0.95 and study.honest[EKF] < 0.15
    assert says(study, EKF) == "overconfident"
    assert study.ratio(EKF) > 3e3 and study.ratio(UKF) < 4 and study.nees[EKF][-1] > 1000 * study.nees[UKF][-1]
    assert 1.3 < study.nis[EKF].mean() < 4.5 and 0.9 < study.nis[UKF].mean() < 1.1


def test_least_squares_over_all_readings_reach_the_bound_that_the_unscented_filter_errs_three_times():
    """Gauss and Newton over the start of each run, with slopes by a complex step; so the bound is no empty threat."""
    design, runs = LESSON.start(), 50
    rng = np.random.default_rng([int(design["seed"]), 14])
    case, e = experiment_of(design, runs, case_of(FALL_CASE).full, rng)
    samples, none = list(simulate_filters(e, rng)), np.zeros((0, 1))
    true, unit = samples[0].x, case.spread
    found = true.copy()
    for _ in range(4):
        x, S = found, np.broadcast_to(np.diag(unit), (runs, 3, 3))
        J, g = np.broadcast_to(np.eye(3), (runs, 3, 3)), ((case.guess[:, None] - x) / unit[:, None]).T
        for k, sample in enumerate(samples):
            if k:
                x, F = slopes(e.flow, x, none)
                S = F @ S
            y, H = slopes(e.output, x, none)
            seen = (H @ S)[:, 0]
            J, g = J + seen[:, :, None] * seen[:, None] / e.R.item(), g + seen * (sample.y - y).T / e.R.item()
        found = found + unit[:, None] * np.linalg.solve(J, g[..., None])[..., 0].T
    bound = many(case=FALL_CASE).bound
    assert 0.7 < np.sqrt(np.mean((found - true)[2]**2)) / bound.rms[-1] < 1.3
    assert 2.5 < bound.times[UKF] < 4.5 and bound.times[EKF] > 8


@pytest.mark.slow
def test_on_the_falling_body_most_ensembles_of_the_unscented_filter_lie_in_the_band():
    low, high = chi2_band(3, count=JOB_RUNS, level=0.99)
    studies_ = [many(case=FALL_CASE, seed=seed) for seed in range(30)]
    ends = np.array([s.nees[UKF][-1] for s in studies_])
    assert low < np.median(ends) < high and np.mean(ends < high) > 0.5 and (ends > low * 0.8).all()
    errors = np.median([[1e3 * s.rms[EKF][20, 1], 1e3 * s.rms[UKF][20, 1]] for s in studies_], axis=0)
    assert 0.14 < errors[0] < 0.18 and 0.04 < errors[1] < 0.06  # the prediction's 0.16 and 0.05 per km


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_the_pole_makes_the_extended_filter_overconfident_and_falls_with_the_linear_one(seed):
    by = {name: many(case=PENDULUM_CASE, filter=name, seed=seed) for name in FILTERS}
    assert by[KF].fallen >= 35 and max(by[EKF].fallen, by[UKF].fallen) <= 10
    assert says(by[UKF], EKF) == "overconfident" and says(by[UKF], KF) == "overconfident"
    assert by[UKF].nees[EKF].max() > 7 * 4
    assert 0.6 * np.median(by[UKF].nees[EKF]) > np.median(by[UKF].nees[UKF]) * 0.6
    assert np.median(by[UKF].nees[UKF]) < 4.8
    wide = many(case=PENDULUM_CASE, filter=UKF, seed=seed, size=2.0)
    assert wide.fallen > 15 and says(wide, UKF) != "consistent"


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_on_the_platform_the_extended_filter_is_honest_up_to_an_amplitude(seed):
    """γ = 0.3: consistent at half the uncertainty, off for the first half second at one, thousands at two, the UKF far less."""
    small, one, two = (many(size=size, seed=seed) for size in (0.5, 1.0, 2.0))
    assert says(small, EKF) == says(small, UKF) == says(one, UKF) == "consistent"
    assert all(0.9 < one.bound.times[name] < 1.12 for name in (EKF, UKF)) and one.bound.times[KF] > 3
    assert says(small, KF) == says(one, KF) == says(two, KF) == "overconfident"
    high = chi2_band(6, count=JOB_RUNS, level=0.9999)[1]
    after = one.t > 0.6
    assert one.nees[EKF].max() > high and (one.nees[EKF][after] < 1.1 * high).all()
    assert two.nees[EKF].max() > 3000 and 15 < two.nees[UKF].max() < 3000
    assert two.nees[EKF].max() > 20 * two.nees[UKF].max()


@pytest.mark.slow
@pytest.mark.parametrize("task", by_knobs(LESSON.tasks), ids=lambda t: t.id)
def test_tasks_hold_for_any_seed(task):
    for seed in range(20):
        start = LESSON.apply(LESSON.start(), {"seed": seed})
        assert not task.check(LESSON.compute(start)).solved
        assert task.check(LESSON.compute(LESSON.apply(start, task.solution))).solved, seed


def test_the_job_keeps_what_only_the_view_changes():
    first = LESSON.compute(LESSON.apply(LESSON.start(), {"case": FALL_CASE}))
    assert LESSON.job is not None
    *_, (_, last) = LESSON.job.outcomes(first)
    assert last.study.runs == JOB_RUNS
    for values, kept in (({"line": "S"}, True), ({"filter": UKF}, True), ({"size": 0.7}, False), ({"seed": 3}, False)):
        after = LESSON.compute(LESSON.apply(first.design, values))
        assert (carried(LESSON, last.design, last.study, after).study.runs == JOB_RUNS) == kept, values
    steered = LESSON.compute(LESSON.apply(LESSON.start(), {"case": PENDULUM_CASE}))
    *_, (_, done) = LESSON.job.outcomes(steered)
    after = LESSON.compute(LESSON.apply(steered.design, {"filter": UKF}))
    assert carried(LESSON, done.design, done.study, after) is after  # another filter steers: other runs


# --- what the page claims ----------------------------------------------------------------------------------------------------
@pytest.mark.slow
def test_a_known_start_leaves_the_kf_five_times_overconfident_and_the_ekf_honest():
    """Solution of the second task, by the two hundred runs of the button."""
    first = LESSON.compute(LESSON.apply(LESSON.start(), {"case": PLATFORM, "hardening": 0.6, "size": 0.3}))
    *_, (_, last) = LESSON.job.outcomes(first)
    assert last.metrics["nees_kf"] > 5 and 0.8 < last.metrics["nees_ekf"] < 1.2


@pytest.mark.slow
def test_innovations_of_the_falling_ekf_average_about_two():
    ratios = []
    for seed in SEEDS:
        first = LESSON.compute(LESSON.apply(LESSON.start(), {"case": FALL_CASE, "seed": seed}))
        *_, (_, last) = LESSON.job.outcomes(first)
        ratios.append(last.metrics["nis_ekf"])
        assert last.metrics["nees_ekf"] > 1000
    assert 1.5 < np.median(ratios) < 2.5


def test_an_uncertain_start_is_not_called_honest_by_the_luck_of_a_draw():
    small = next(t for t in LESSON.tasks if t.id == "small")
    for seed in range(1, 9):
        for values in ({"hardening": 0.5}, {"hardening": 0.5, "size": 0.8}):
            assert not small.check(LESSON.compute(LESSON.apply(LESSON.start(), {"case": PLATFORM, "seed": seed, **values}))).solved


def test_a_filter_is_called_consistent_only_where_its_nees_lies_in_the_band():
    """By scipy's own band, and for spreads of every size: what is far from the expected mean is never called consistent."""
    rng = np.random.default_rng(44)
    for _ in range(200):
        dof, runs, samples = int(rng.integers(2, 8)), int(rng.choice([8, 50, 200])), int(rng.integers(20, 120))
        factor = float(np.exp(rng.uniform(-0.7, 0.7)))
        values = factor * chi2.rvs(dof * runs, size=samples, random_state=rng) / runs
        low, high = chi2.ppf([0.025, 0.975], dof * runs) / runs
        inside, mean = float(np.mean((values >= low) & (values <= high))), float(np.mean(values)) / dof
        said = verdict(values, dof, runs)("en")
        assert (said == "consistent") <= (inside >= 0.7), (factor, dof, runs)
        assert (said == "nearly consistent") <= (abs(mean - 1) <= 0.2)
        assert (said == "under-confident") <= (mean < 1)
        assert said.startswith("overconfident") or said in ("consistent", "nearly consistent", "under-confident")
        assert (factor < 0.7 and runs == 200) <= (said == "under-confident")


def test_the_bars_on_the_stage_are_what_the_filter_states_and_its_rms_error_in_decades() -> None:
    for values, unit, (low, high) in (({"filter": "ekf"}, 1e3, (-3, 5)), ({"case": "platform", "filter": "kf"}, 1e3, (-2, 2))):
        o = LESSON.compute(LESSON.apply(LESSON.start(), values))
        study, who, stage = o.study, values["filter"], o.stage
        state, signal = (2, 1) if "case" not in values else (1, 0)
        k = len(study.t) - 1
        sizes = [unit * study.sigmas[who][k, state], unit * study.rms[who][k, signal]]
        long = [stage.body.pose(stage.x[-1].tolist(), stage.body.gain)[f"bar {j}"].scale[2] for j in (0, 1)]
        shares = np.clip((np.log10(sizes) - low) / (high - low), 0.004, 1)
        np.testing.assert_allclose(long, 3.2 * shares, rtol=1e-6)


def test_the_gate_stands_at_the_stated_sigma_so_that_an_overconfident_filter_passes_it() -> None:
    for values, passes in (({"filter": "ekf"}, True), ({"filter": "kf"}, True), ({"filter": "ukf"}, False)):
        stage = LESSON.compute(LESSON.apply(LESSON.start(), values)).stage
        poses = stage.body.pose(stage.x[200].tolist(), 1.0)  # 20 s
        ends = [poses[f"bar {j}"].position[0] + poses[f"bar {j}"].scale[2] for j in (0, 1)]
        assert poses["gate"].position[0] == pytest.approx(ends[0])
        assert (ends[1] > ends[0] + 0.2) == passes


def on_stage(who: str, at: int, **values: float) -> tuple[Study, dict, dict]:
    """The study, and the poses of body and ghost at a second of the run."""
    o = LESSON.compute(LESSON.apply(LESSON.start(), {"filter": who, **values}))
    return o.study, *(o.stage.body.pose(states[10 * at].tolist(), 1.0) for states in (o.stage.x, o.stage.xhat))


def turned(pose) -> np.ndarray:
    """The direction in the plane of the fall in which a rod points."""
    w, x, y, z = pose.wxyz
    return np.array([2 * (x * z + w * y), 1 - 2 * (x * x + y * y)])


@pytest.mark.parametrize("at", (2, 6, 12))
def test_the_tangent_goes_through_the_body_as_steep_as_the_filter_takes_it(at: int) -> None:
    """That of the EKF is taken at its estimate, that of the KF at the first one, all the way; the UKF has none."""
    for who in (EKF, KF, UKF):
        study, body, ghost = on_stage(who, at)
        place, radar = (np.array(body[name].position)[[0, 2]] for name in ("capsule", "turret"))
        long = ghost["tangent"].scale[2]
        if who == UKF:
            assert long < 1e-3
            continue
        begin = np.array(ghost["tangent"].position)[[0, 2]]
        np.testing.assert_allclose(begin + long / 2 * turned(ghost["tangent"]), place, atol=1e-9)
        seen = study.x[at, 0] + 100 * (study.means[who][at, 0] - study.x[at, 0]) if who == EKF else 300_000 * 0.3048
        up = (seen - study.x[at, 0]) * 2.6e-5 + place[1] - radar[1]
        assert turned(ghost["tangent"]) @ (place[0] - radar[0], up) == pytest.approx(0, abs=1e-6)
        far = [np.hypot(*(np.array(body[f"arc {i}"].position)[[0, 2]] - radar)) for i in range(12) if body[f"arc {i}"].position[2] > 0.17]
        np.testing.assert_allclose(far, np.hypot(*(place - radar)))


@pytest.mark.parametrize("who", FILTERS)
def test_the_line_of_the_true_altitude_is_in_the_band_of_the_ghost_exactly_where_the_truth_is_within_three_sigma(who: str) -> None:
    beside = 0
    for at in range(1, 31):
        study, body, ghost = on_stage(who, at)
        error, reach = study.means[who][at, 0] - study.x[at, 0], 3 * study.sigmas[who][at, 0]
        true = body["true altitude"].position[2]
        foot, top = (ghost[f"band {end}"].position[2] for end in ("foot", "top"))
        begin, band = min(body["true altitude"].position[0], body["true altitude"].position[0] + body["true altitude"].scale[2] * turned(
            body["true altitude"])[0]), ghost["band"].position[0]
        assert true == body["capsule"].position[2] and begin == pytest.approx(body["capsule"].position[0])
        assert begin + body["true altitude"].scale[2] > band + 0.4 and ghost["capsule"].position[0] > band + 0.4 + 0.75 * 0.33
        assert (foot < true < top) == (abs(error) < reach), at
        assert foot <= ghost["capsule"].position[2] <= top
        beside += abs(error) >= reach
    assert (beside > 25) == (who == KF)  # the linear filter states a small error and makes a large one


@pytest.mark.parametrize("who", FILTERS)
def test_the_curves_have_their_names_at_their_ends_and_the_estimate_is_a_line_from_its_band_to_its_ghost(who: str) -> None:
    """±3σ above its band, equal distances at the upper end of the curve, the tangent's name past its right end, none for the UKF."""
    o = LESSON.compute(LESSON.apply(LESSON.start(), {"filter": who}))
    for at in (60, 200):
        x, xhat = o.stage.x[at].tolist(), o.stage.xhat[at].tolist()
        body, ghost = (o.stage.body.pose(each, 1.0) for each in (x, xhat))
        named = {words("en"): place for words, place, _ in o.stage.body.marks(x, xhat, 1.0).words if not isinstance(words, str)}
        assert named["±3σ × 100"][2] == pytest.approx(ghost["band top"].position[2] + 0.07)
        assert named["±3σ × 100"][0] == ghost["band"].position[0]
        last = body["arc 11"]
        end = np.array(last.position)[[0, 2]] + last.scale[2] * turned(last)
        np.testing.assert_allclose(np.array(named["equal distances"])[[0, 2]], end + np.array([0.0, 0.07]))
        tangent = ghost["tangent"]
        begin = np.array(tangent.position)[[0, 2]]
        right = max([begin, begin + tangent.scale[2] * turned(tangent)], key=lambda point: point[0])
        if who == UKF:
            assert named["tangent"][2] < -5
        else:
            np.testing.assert_allclose(np.array(named["tangent"])[[0, 2]], right + np.array([0.07, 0.0]))
        line = ghost["estimated altitude"]
        np.testing.assert_allclose(line.position[2], ghost["capsule"].position[2])
        assert line.position[0] + line.scale[2] == pytest.approx(ghost["capsule"].position[0])
        assert line.position[0] == pytest.approx(ghost["band"].position[0] - 0.4)


def test_a_small_error_of_the_ghost_is_drawn_a_hundred_times_to_scale_and_a_large_one_stays_on_the_stage() -> None:
    study, body, ghost = on_stage(UKF, 20)  # 16 m: 4 cm of the stage
    error = study.means[UKF][20, 0] - study.x[20, 0]
    assert ghost["capsule"].position[2] - body["capsule"].position[2] == pytest.approx(100 * error * 2.6e-5, rel=0.01)
    study, body, ghost = on_stage(KF, 13, sensor=0.1)  # 36 km
    top = body["ruler"].position[2] + body["ruler"].scale[2]
    assert ghost["nose"].position[2] < top and ghost["capsule"].position[2] > body["capsule"].position[2] + 1.5


@pytest.mark.parametrize("case", ["fall", "pendulum", "platform"])
def test_the_bars_of_both_tests_are_their_means_over_the_runs_and_say_their_sizes(case: str) -> None:
    """A bar of 10^-2 to 10^6 is as long as NEES per state, or NIS per reading, of the filter of the ghost."""
    o = LESSON.compute(LESSON.apply(LESSON.start(), {"case": case, "bars": "tests"}))
    stage, study = o.stage, o.study
    assert stage is not None and stage.xhat is not None and stage.body.marks is not None
    step = (len(stage.t) - 1) // (len(study.t) - 1)
    for k in (0, len(study.t) // 2, len(study.t) - 1):
        sizes = study.nees[EKF].mean() / study.x.shape[1], study.nis[EKF].mean() / len(study.case.R)
        state = stage.x[step * k].tolist()
        poses, words = stage.body.pose(state, 1.0), stage.body.marks(state, state, 1.0).words
        for bar, size in enumerate(sizes):
            share = np.clip((np.log10(max(size, 1e-2)) + 2) / 8, 0.004, 1)
            assert poses[f"bar {bar}"].scale[2] == pytest.approx(3.2 * share, abs=1e-6)
            if 1e-2 < size < 1000:
                assert float(words[bar][0]) == pytest.approx(size, rel=0.06)
