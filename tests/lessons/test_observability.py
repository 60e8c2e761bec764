"""Observability: published numbers, rank against distance, x(0) from y, and the ellipsoid that data leave."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad_vec, solve_ivp
from scipy.linalg import expm

from observer_lab.course.figures.records import PlaneFigure
from observer_lab.course.lesson import Stage
from observer_lab.engine import Plant, observability, observer_gain
from observer_lab.lessons.observability.cases import PLANT_CASES, READING, sensed
from observer_lab.lessons.observability.criteria import DET, GRAMIAN, PBH, RANK_CRITERION
from observer_lab.lessons.observability.initial_state import KNOWN_SHARE, learn
from observer_lab.lessons.observability.knob_sweep import least_distance, least_ratio
from observer_lab.lessons.observability.lesson import LESSON
from observer_lab.lessons.observability.study import Study, judged
from observer_lab.plants.own_plant import own_model


def outcome(**changes):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def found(**changes) -> Study:
    return outcome(**changes).study


def stage_of(**changes) -> Stage:
    stage = outcome(**changes).stage
    assert stage is not None
    return stage


def test_the_notes_example_as_printed():
    """Observer notes (001), section 2.2: O = [1 0; 1 2], rank 2; singular values and poles recomputed."""
    f = found(plant="notes", rows_two=2)
    np.testing.assert_array_equal(f.rebuilt.matrix, [[1, 0], [1, 2]])
    assert f.rank == f.rebuilt.rank == 2
    np.testing.assert_allclose(f.rebuilt.sizes, [2.2882, 0.8740], atol=5e-5)
    np.testing.assert_allclose([m.pole for m in f.sensed.seen.modes], [-0.37228, 5.37228], atol=5e-6)


def test_rows_come_one_by_one_and_each_opens_a_direction():
    assert [found(plant="notes", rows_two=k).rebuilt.rank for k in (1, 2)] == [1, 2]
    A = sensed(LESSON.apply(LESSON.start(), {"left": -0.15})).plant.A
    C = sensed(LESSON.apply(LESSON.start(), {"left": -0.15})).plant.C
    for k in range(1, 7):
        f = found(left=-0.15, rows_deck=k)
        np.testing.assert_allclose(f.rebuilt.matrix[-1:], C @ np.linalg.matrix_power(A, k - 1), rtol=1e-9, atol=1e-9)
        assert f.rebuilt.rank == k


def test_start_from_y_and_its_derivative_by_hand():
    """x₁ = y, x₂ = (ẏ − y)/2 for the notes' example, as the step says; one row leaves x₂ open."""
    f = found(plant="notes", rows_two=2, reading=1e-12)
    y, dy = f.rebuilt.data
    np.testing.assert_allclose(f.rebuilt.guess, [y, (dy - y) / 2], rtol=1e-12)
    np.testing.assert_allclose(f.rebuilt.guess, f.start, atol=1e-10)
    one = found(plant="notes", rows_two=1, reading=1e-12).rebuilt
    np.testing.assert_allclose(one.guess, [f.start[0], 0.0], atol=1e-10)
    np.testing.assert_array_equal(one.share.round(12), [1.0, 0.0])


def test_derivatives_are_those_of_y():
    """The data that O is solved with are y, ẏ, ÿ at 0, here by mpmath's numerical differentiation."""
    f = found(plant="notes", rows_two=2)
    A, x0 = mpmath.matrix([[1, 2], [3, 4]]), mpmath.matrix(f.start.tolist())
    for order, value in enumerate(f.rebuilt.exact):
        assert float(mpmath.diff(lambda t: (mpmath.expm(A * t) * x0)[0], 0, order)) == pytest.approx(value, abs=1e-8)


def test_directions_below_the_tolerance_stay_open():
    """σ₂/σ₁ of the pair's O is about ε/4: with τ above it only x₁ + x₂ = y is solved, by the shortest x(0)."""
    f = found(plant="pair", gap=1e-5, rows_two=2, tolerance=1e-3, reading=1e-12)
    assert f.rank == f.rebuilt.rank == 1
    np.testing.assert_allclose(f.rebuilt.share, 0.5, atol=1e-4)
    np.testing.assert_allclose(f.rebuilt.guess, np.sum(f.start) / 2, atol=1e-4)


def test_reading_errors_are_blown_up_by_near_unobservability():
    errors = [outcome(plant="pair", gap=gap, rows_two=2, reading=1e-6).metrics["rebuild_error"] for gap in (1e-1, 1e-3, 1e-5)]
    assert errors[0] < 1e-4 < errors[1] < 1e-2 < errors[2]


def test_twenty_modes_low_rank_and_nothing_hidden():
    """numerics.md, trap 1: rank(O) = 7 while every PBH distance exceeds 0.4; shown as both, never as one number."""
    o = outcome(plant="many", count=20)
    f = o.study
    assert f.rank == 7 == found(plant="many", count=20, rows_many=20).rebuilt.rank and f.sensed.seen.observable and f.sensed.seen.rank == 20
    A, C = -np.diag(np.arange(1.0, 21.0)), np.ones((1, 20))
    peers = [np.linalg.svd(np.vstack([A + k * np.eye(20), C]), compute_uv=False)[-1] for k in range(1, 21)]
    assert min(peers) > 0.4
    assert o.metrics["weakest"] == pytest.approx(min(peers), rel=1e-9)
    assert judged(f) == "unresolved"
    assert "No mode is hidden" in o.live("en") and "7" in o.live("en") and " of 20 " in o.live("en")
    assert {c.id: c.holds for c in o.checks} == {"rank": False, "seen": True, "clear": True, "known": False}


def test_true_rank_of_twenty_modes_is_twenty():
    """O is a Vandermonde matrix of twenty different poles: not singular, only beyond double precision."""
    with mpmath.workdps(80):
        O = mpmath.matrix([[mpmath.mpf(-j) ** k for j in range(1, 21)] for k in range(20)])
        assert abs(mpmath.det(O)) > 1


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8])
def test_near_unobservable_pair_is_called_so_at_full_rank(gap):
    o = outcome(plant="pair", gap=gap)
    assert o.metrics["rank"] == 2 and judged(o.study) == "near"
    assert o.metrics["weakest"] == pytest.approx(gap / np.sqrt(2), rel=0.02)
    assert o.live("en").startswith("Nearly unobservable")
    L = observer_gain(np.diag([-1.0, -1.0 - gap]), np.ones((1, 2)), (-2.0, -3.0)).gain
    assert np.linalg.norm(L) * gap == pytest.approx(2.8, abs=0.1)


def test_middle_sensor_sees_the_vertical_motion_only():
    f = found()
    hidden = {round(p.imag, 2) for p in f.sensed.seen.unobservable if p.imag > 0}
    assert judged(f) == "hidden" and f.sensed.seen.rank == 2 and hidden == {6.25, 7.49}
    spread = np.sqrt(np.diagonal(f.belief.P[-1]))
    np.testing.assert_allclose(spread[[0, 2, 3, 5]], 1.0, atol=1e-9)  # x, θ and their rates: as wide as before
    assert np.all(spread[[1, 4]] < KNOWN_SHARE)


def test_horizontal_sensor_misses_the_vertical_motion():
    f = found(left_on=False, across_on=True)
    assert {round(p.imag, 2) for p in f.sensed.seen.unobservable if p.imag > 0} == {9.39}
    assert judged(found(left_on=False)) == "hidden"  # no sensor at all


@pytest.mark.parametrize("place", [-0.2, -0.1, 0.03, 0.15])
def test_one_sensor_off_the_middle_sees_all_and_farther_is_better(place):
    f = found(left=place)
    assert f.sensed.seen.observable
    assert outcome(left=1.1 * place if abs(place) < 0.18 else place).metrics["weakest"] >= outcome(left=place).metrics["weakest"]
    assert outcome(left=place).metrics["weakest"] == pytest.approx(outcome(left=-place).metrics["weakest"], rel=0.2)


def test_typical_sizes_change_numbers_not_the_plant():
    f = found(left=-0.1, right_on=True, across_on=True)
    S = np.diag(PLANT_CASES["deck"].scale)
    own = Plant(S @ f.sensed.plant.A @ np.linalg.inv(S), np.zeros((6, 1)), READING * f.sensed.plant.C @ np.linalg.inv(S))
    np.testing.assert_allclose(own.C, [[0, 0, 0, 0, 1, -0.1], [0, 0, 0, 0, 1, 0.072], [0, 0, 0, 1, 0, 0.014978]], atol=1e-12)
    np.testing.assert_allclose(observability(own).rank, f.sensed.seen.rank)


def test_blind_directions_of_the_notes_sensor():
    """C = [cos φ, sin φ] is blind for an eigenvector of [1 2; 3 4] at a right angle to it."""
    values, vectors = np.linalg.eig(np.array([[1.0, 2.0], [3.0, 4.0]]))
    blind = dict(zip(values.round(3).tolist(), np.degrees(np.arctan2(-vectors[0], vectors[1])).tolist(), strict=True))
    blind = {k: (v + 90) % 180 - 90 for k, v in blind.items()}
    assert blind[-0.372] == pytest.approx(55.54, abs=0.01)
    for pole, angle in blind.items():
        f = found(plant="notes", angle=angle)
        assert not f.sensed.seen.observable or f.weakest.distance < 1e-12
        assert f.weakest.pole.real == pytest.approx(pole, abs=1e-3)
        assert {c.id: c.says for c in f.criteria} == {DET: None, RANK_CRITERION: False, GRAMIAN: False, PBH: False}


@pytest.mark.parametrize("changes", [{"plant": "notes"}, {"left": -0.15}, {"plant": "pair", "gap": 0.1},
                                     {"left": 0.1, "right_on": True, "across_on": True}])
def test_gramian_is_the_integral(changes):
    s = sensed(LESSON.apply(LESSON.start(), changes))
    A, C = s.plant.A, s.plant.C
    for k in (1, 37, len(s.t) - 1):
        peer, _ = quad_vec(lambda t: expm(A.T * t) @ C.T @ C @ expm(A * t), 0, s.t[k], epsabs=1e-12, epsrel=1e-10)
        np.testing.assert_allclose(s.energy[k], peer, rtol=1e-8, atol=1e-9 * np.abs(peer).max())


@pytest.mark.parametrize("changes", [{}, {"left": -0.15}, {"plant": "notes"}, {"plant": "pair"}, {"plant": "many"}])
def test_the_ellipsoid_never_grows(changes):
    """More data never widen a direction: P(s) − P(t) ⪰ 0 for s < t."""
    b = found(**changes).belief
    np.testing.assert_allclose(b.P[0], np.eye(len(b.mean[0])), atol=1e-12)
    assert np.linalg.eigvalsh(b.P[:-1] - b.P[1:]).min() > -1e-9
    assert np.all(np.diff(b.halves, axis=0) <= 1e-9)
    np.testing.assert_allclose(np.sqrt(np.linalg.eigvalsh(b.P[-1]))[::-1], b.halves[-1], rtol=1e-4, atol=1e-7)


def test_the_ellipsoid_holds_the_truth_as_often_as_it_says():
    """x(0) ~ N(0, I): the squared distance of the truth in the metric of P has mean n and variance 2n at every time."""
    s, rng = sensed(LESSON.apply(LESSON.start(), {"left": -0.15})), np.random.default_rng(7)
    trials, at = 600, 70
    squares = []
    for seed in range(trials):
        start = rng.standard_normal(6)
        b = learn(s, start, 0.05, 1000 + seed)
        gap = start - b.mean[at]
        squares.append(gap @ np.linalg.solve(b.P[at], gap))
    assert np.mean(squares) == pytest.approx(6, abs=5 * np.sqrt(12 / trials))
    assert np.var(squares) == pytest.approx(12, rel=0.5)


def test_less_noise_means_a_smaller_ellipsoid_but_not_for_a_hidden_direction():
    loud, quiet = (found(noise=nu).belief.halves[-1] for nu in (0.3, 0.003))
    assert quiet[-1] < 0.02 * loud[-1] * 1.1
    np.testing.assert_allclose([quiet[:4], loud[:4]], 1.0, atol=1e-9)


def test_the_sentence_of_the_notes_says_nothing():
    """C e^{At} is 1×2 at every t, so there is no determinant; the other three agree, and refuse a blind direction."""
    says = {c.id: c.says for c in found(plant="notes").criteria}
    assert says == {DET: None, RANK_CRITERION: True, GRAMIAN: True, PBH: True}
    s = found(plant="notes").sensed
    assert all(np.linalg.matrix_rank(s.plant.C @ phi) == 1 for phi in s.powers)
    says = {c.id: c.says for c in found().criteria}
    assert says == {DET: None, RANK_CRITERION: False, GRAMIAN: False, PBH: False}


def test_a_gramian_below_rounding_does_not_say_no_where_nothing_is_hidden():
    for changes in ({"plant": "many", "count": 20}, {"plant": "pair", "gap": 1e-8}):
        assert {c.id: c.says for c in found(**changes).criteria}[GRAMIAN] is None


def test_the_drawn_ellipse_passes_the_95_percent_bound():
    """Half axes of the plane's last ellipse: √(5.9915 λ(P)), χ² of 2 at 95 %."""
    o = outcome(plant="notes")
    figure = next(f for f in LESSON.figures(o) if f.id == "ellipses")
    assert isinstance(figure, PlaneFigure)
    last = figure.curves[-1]
    assert last.x is not None
    ring = np.column_stack([last.x, last.y]) - o.study.belief.mean[-1]
    squares = np.einsum("ki,ij,kj->k", ring, np.linalg.inv(o.study.belief.P[-1]), ring)
    np.testing.assert_allclose(squares, 5.9915, rtol=1e-4)


def test_the_drawn_ellipsoid_is_the_marginal_of_the_positions():
    cloud, P = stage_of(left=-0.15).x[-1, 11:], found(left=-0.15).belief.P[-1]
    w, x, y, z = cloud[6:10]
    R = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                  [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                  [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
    drawn = R @ np.diag(cloud[3:6] ** 2) @ R.T
    order = [0, 2, 1]  # right = x, away = θ, up = z
    np.testing.assert_allclose(drawn, 7.8147 * P[np.ix_(order, order)], rtol=1e-4, atol=1e-8)  # χ² of 3 at 95 %


def test_sensors_on_the_body_stand_where_the_knobs_say():
    near, far = stage_of(left=-0.05), stage_of(left=-0.15)
    rest = np.zeros(6).tolist()
    places = [stage.body.pose(rest + stage.x[0, 6:].tolist(), 1.0)["sensor left"].position[0] for stage in (near, far)]
    assert places[0] == pytest.approx(-0.05 * 7.5) and places[1] == pytest.approx(-0.15 * 7.5)
    on, off = (stage_of(right_on=v) for v in (True, False))
    colours = [s.body.pose(s.x[0].tolist(), 1.0)["sensor right"].colour for s in (on, off)]
    assert colours[0] != colours[1] and on.body is off.body


# --- sentences -----------------------------------------------------------------------------------------------------
def test_both_curves_of_the_sweep_depend_on_the_unit_of_time_as_its_caption_says():
    for A, C in ((np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[1.0, 0.0]])), (np.diag([-1.0, -2.0, -3.0]), np.ones((1, 3)))):
        assert least_distance(A, C) > 1.5 * least_distance(A / 10, C) > 0
        assert not np.isclose(least_ratio(A, C), least_ratio(A / 10, C), rtol=0.1)


@pytest.mark.parametrize("count", [2, 8, 14, 20])
def test_an_eigenvalue_below_rounding_is_not_called_zero(count):
    o = outcome(plant="many", count=count)
    words = next(f for f in LESSON.figures(o) if f.id == "energy").caption("en")
    s = o.study.sensed
    assert ("below rounding" in words) == (s.heard[-1, 0] <= s.dust)
    assert "smallest 0. W" not in words and "not heard at all" not in next(f for f in LESSON.figures(o) if f.id == "halves").caption("en")


def test_a_singular_value_without_a_right_digit_is_not_given_as_a_number():
    for values, said in (({"plant": "many", "rows_many": 20}, "lost in rounding"),
                         ({"plant": "pair", "gap": 1e-8, "rows_two": 2}, "10⁻⁹ times")):
        assert said in str(next(f for f in LESSON.figures(outcome(**values)) if f.id == "sizes").caption)


def test_a_plant_whose_states_are_all_measured_is_not_said_to_have_no_determinant():
    own = LESSON.adapt(LESSON, own_model(Plant(np.diag([-1.0, -2.0]), np.ones((2, 1)), np.eye(2))))
    found = own.compute(own.start())
    said = str(next(f for f in own.figures(found) if f.id == "criteria").caption)
    assert "2×2 here and has a determinant" in said


def test_a_rank_cut_by_a_coarse_tolerance_is_not_called_rounding():
    task = next(t for t in LESSON.tasks if t.id == "low-rank")
    assert task.check(outcome(plant="many", count=20)).solved
    coarse = task.check(outcome(plant="many", count=4, tolerance=0.1))
    assert not coarse.solved and "rounding" in coarse.text("en")


@pytest.mark.parametrize("second", ["x", "z", "theta"])
@pytest.mark.parametrize("sensors", [{}, {"left_on": False, "across_on": True}, {"left": 0.1}, {"across_on": True}], ids=str)
def test_two_starts_read_alike_exactly_where_their_difference_is_in_the_kernel(sensors: dict, second: str) -> None:
    """The gap of the readings by scipy's integrator in metres, beside what the caption says; the kernel by numpy's svd of O."""
    o = LESSON.compute(LESSON.apply(LESSON.start(), {**sensors, "second": second}))
    plant, twins = o.study.sensed.plant, o.study.twins
    run = solve_ivp(lambda t, x: plant.A @ x, (0, o.study.sensed.t[-1]), twins.v, t_eval=o.study.sensed.t, rtol=1e-10, atol=1e-13)
    gap = np.abs(plant.C @ run.y).max()
    assert twins.gap == pytest.approx(gap, abs=1e-8)
    O = np.vstack([plant.C @ np.linalg.matrix_power(plant.A, k) for k in range(plant.n)])
    hidden = np.abs(O @ twins.v).max() < 1e-9 * np.abs(O).max()
    said = next(f for f in LESSON.figures(o) if f.id == "two-readings").caption("en")
    assert ("agree at every time" in said) == hidden == (twins.gap < 1e-9)


def test_a_plant_that_is_barely_observable_is_not_said_to_read_alike() -> None:
    o = LESSON.compute(LESSON.apply(LESSON.start(), {"plant": "pair", "gap": 1e-8}))
    said = next(f for f in LESSON.figures(o) if f.id == "two-readings").caption("en")
    assert "less than their noise" in said and "agree" not in said


@pytest.mark.parametrize("changes", [{"plant": "notes"}, {"plant": "pair"}, {"plant": "many", "count": 6}], ids=lambda each: each["plant"])
def test_the_axes_of_the_cloud_and_the_columns_bear_the_names_of_their_states(changes: dict) -> None:
    """The blue point is where x(0) is by the named axes, and each head stands above the name of its state."""
    stage = stage_of(**changes)
    n = int(changes.get("count", 2))
    names = [str(words) for words, _ in stage.body.labels]
    assert names[:n] == [f"x{'₁₂₃₄₅₆'[i]}" for i in range(n)] and names[n:] == names[:min(n, 3)]
    poses, middle, places = stage.body.pose(stage.x[0].tolist(), 1.0), np.array((0.0, -0.1, 3.2)), [at for _, at in stage.body.labels]
    assert [poses[f"head {i}"].position[0] for i in range(n)] == pytest.approx([at[0] for at in places[:n]])
    ways = np.array(places[n:]) - middle
    point = 0.3 * stage.x[0, :len(ways)] @ (ways / np.linalg.norm(ways, axis=1, keepdims=True))
    assert np.array(poses["truth"].position) - middle == pytest.approx(point)


def test_the_second_deck_moves_from_the_second_start_and_the_reading_does_not_tell_it() -> None:
    """Both decks run by e^{At} from starts 2 mm apart in height; the ghost gives way to the second one."""
    changes = {"twin": True, "left_on": False, "right_on": False, "across_on": True}
    stage, study = stage_of(**changes), found(**changes)
    assert stage.xhat is None and stage_of(**changes | {"twin": False}).xhat is not None
    difference = stage.x[:, 24:] - stage.x[:, :6]
    assert difference[0] == pytest.approx([0, 0.002, 0, 0, 0, 0])
    for k in (30, 100):
        raw = np.array(study.case.scale)
        A = study.sensed.plant.A * raw[:, None] / raw[None]
        assert difference[k] == pytest.approx(expm(A * stage.t[k]) @ difference[0], abs=1e-9)
        poses = stage.body.pose(stage.x[k].tolist(), stage.body.gain)
        alone = stage.body.pose([*stage.x[k, 24:], *stage.x[k, 6:]], stage.body.gain)["deck"]
        assert poses["second deck"].position == alone.position and poses["second deck"].wxyz == alone.wxyz


def test_the_axes_of_the_cloud_of_the_deck_bear_the_names_of_its_states_at_their_far_ends() -> None:
    """x to the right, z up, θ away from the viewer, as the record of the cloud has them; the cloud hangs at (0, −0.1, 3.2)."""
    stage = stage_of(plant="deck")
    places = {str(words): np.array(at) - (0.0, -0.1, 3.2) for words, at in stage.body.labels}
    assert set(places) == {"x", "z", "θ"}
    for words, along in (("x", 0), ("θ", 1), ("z", 2)):
        assert int(np.argmax(places[words])) == along and places[words][along] > 0.9
