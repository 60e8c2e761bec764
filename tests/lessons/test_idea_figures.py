"""Figures that show an idea: their bars, needles and lines are the numbers of the lesson, at the ends of knobs too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from attack import at_random

from observer_lab.course.figures.gauges import Gauge, GaugeFigure
from observer_lab.course.figures.records import PlaneFigure
from observer_lab.course.lesson import Lesson, Outcome
from observer_lab.engine import Plant
from observer_lab.lessons import LESSONS
from observer_lab.lessons.bilinear_observer.problems import PROBLEMS
from observer_lab.lessons.fault_diagnosis.bank_figures import HIGHEST
from observer_lab.lessons.fault_diagnosis.figures import decisive
from observer_lab.lessons.record.figures import TOP
from observer_lab.lessons.robust_observer.study import EXAMPLE_CASES
from observer_lab.plants.examples import EXAMPLES, example
from observer_lab.plants.own_plant import canonical_text


def shown(lesson: Lesson, outcome: Outcome, name: str) -> Any:
    return next(figure for figure in lesson.figures(outcome) if figure.id == name)


def plane(lesson: Lesson, outcome: Outcome, name: str) -> PlaneFigure:
    figure = shown(lesson, outcome, name)
    assert isinstance(figure, PlaneFigure)
    return figure


def at(name: str, **values: object) -> tuple[Lesson, Outcome]:
    lesson = LESSONS[name]
    return lesson, lesson.compute(lesson.apply(lesson.start(), values))


def inside(gauge: Gauge) -> bool:
    assert gauge.at is not None
    return gauge.band[0] <= gauge.at <= gauge.band[1]


# --- kalman ------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("noise", ["white", "coloured", "carried"])
@pytest.mark.parametrize("q", [0.01, 0.05, 1.0, 100.0])
def test_a_needle_is_in_its_band_exactly_where_the_test_passes(noise: str, q: float) -> None:
    figure = shown(*at("kalman", noise=noise, q=q, r=1.0), "tests")
    assert isinstance(figure, GaugeFigure) and len(figure.gauges) == 4
    for gauge in figure.gauges:
        assert gauge.role == "muted" or inside(gauge) == (gauge.role == "right") == (gauge.verdict("en") == "passes"), gauge.name("en")


@pytest.mark.parametrize("k", [1.0, 5.0, 40.0, 60.0])
def test_the_ellipses_of_one_step_stand_in_one_window_about_one_point(k: float) -> None:
    figure = plane(*at("kalman", k=k, phase="predict"), "ellipses")
    last, prediction = figure.curves[:2]
    for curve in (last, prediction):
        assert figure.x_range[0] <= curve.xs.min() and curve.xs.max() <= figure.x_range[1]
        assert figure.y_range[0] <= curve.y.min() and curve.y.max() <= figure.y_range[1]
    assert np.mean([last.xs[:-1], last.y[:-1]], axis=1) == pytest.approx(np.mean([prediction.xs[:-1], prediction.y[:-1]], axis=1), rel=1e-6)


def test_the_loop_of_the_filter_says_the_size_of_its_gain_and_not_two_dozen_numbers() -> None:
    laws = {block.id: block.law for block in shown(*at("kalman"), "diagram").blocks}
    assert laws["L"] == r"M\quad (6\times 4)"


# --- fault diagnosis, network, arm -------------------------------------------------------------------------------------
@pytest.mark.parametrize("values", [{}, {"place": "HL", "kind": "bias", "bias": 3.0}, {"place": "VR", "kind": "drift", "drift": 4.0}])
def test_each_observer_of_the_bank_has_a_bar_as_high_as_its_test_value_and_an_arrow_beyond_the_edge(values: dict[str, object]) -> None:
    lesson, outcome = at("fault-diagnosis", **values)
    figure, verdict = plane(lesson, outcome, "bank"), outcome.study.verdict
    *bars, line = figure.curves
    row = verdict.values[decisive(outcome.study)]
    assert [float(bar.y[1]) for bar in bars] == pytest.approx([min(value, HIGHEST) for value in row])
    assert [bar.role == "error" for bar in bars] == [bool(value > 1) for value in row] and set(line.y) == {1.0}
    assert [point.x for point in figure.points] == [k for k, value in enumerate(row) if value > HIGHEST]


@pytest.mark.parametrize("loss", [0.0, 0.3, 0.75])
def test_the_variance_grows_where_the_comb_says_that_no_packet_arrives_and_nowhere_else(loss: float) -> None:
    lesson, outcome = at("network", loss=loss)
    variance, comb = shown(lesson, outcome, "first").curves
    lost = comb.y[::2] < comb.y.max() - 1e-12
    assert list(lost) == list(~outcome.study.heard[:len(lost)])
    before, after = variance.y[1:-1:2], variance.y[2::2]  # before and behind the packet of each sample but the first
    assert np.array_equal(after < before * (1 - 1e-9), ~lost[1:])


def test_the_last_row_of_the_arm_s_model_is_zero_and_is_not_there_without_a_state_for_the_load() -> None:
    figure = shown(*at("arm"), "model")
    assert figure.matrix.shape == (4, 4) and not figure.matrix[list(figure.lit)].any() and figure.matrix[:3].any(axis=1).all()
    assert shown(*at("arm", load_state=False), "model").matrix.shape == (3, 3)


# --- weak states -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("order", [4, 8, 10])
def test_each_hankel_value_has_a_bar_that_is_grey_where_it_is_cut(order: int) -> None:
    lesson, outcome = at("weak-states", order=order, pair="5")
    figure, hankel = plane(lesson, outcome, "staircase"), outcome.study.system.hankel
    assert [10.0 ** float(bar.y[1]) for bar in figure.curves] == pytest.approx(list(hankel), rel=1e-9)
    assert [bar.role for bar in figure.curves] == ["plant"] * order + ["muted"] * (10 - order)
    assert [place for place, _ in figure.names] == [1.5, 3.5, 5.5, 7.5, 9.5] and figure.points[0].x == 9.5


@pytest.mark.parametrize("pair", ["1", "3", "5"])
def test_the_bars_of_a_pair_are_the_ways_on_the_stage_and_the_model_loses_a_pair_that_is_cut(pair: str) -> None:
    full, cut = (plane(*at("weak-states", order=order, pair=pair), "pair").curves for order in (10, 8))
    plant, model = ([float(bar.y[1]) for bar in full if bar.role == role] for role in ("plant", "muted"))
    assert max(plant) == pytest.approx(1.0) and model == pytest.approx(plant, abs=1e-6)
    left = max(float(bar.y[1]) for bar in cut if bar.role == "muted")
    assert left < 0.05 if pair == "5" else left > 0.95


# --- sandbox -----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", EXAMPLES)
def test_the_numbers_of_the_sandbox_have_the_verdicts_of_its_table(name: str) -> None:
    lesson = LESSONS["sandbox"].fit(example(name))
    outcome = lesson.compute(lesson.start())
    figure, table = shown(lesson, outcome, "numbers"), shown(lesson, outcome, "lights")
    verdicts = {row[0]("en"): row[1]("en") for row in table.rows}
    asked = ("observable", "controllable", "observer near the Kalman filter", "Kalman filter consistent", "robust at the inputs (α ≥ 0.5)")
    for gauge, question in zip(figure.gauges, asked, strict=True):
        assert {"right": "● yes", "wrong": "○ no", "muted": "— not here"}[gauge.role] == verdicts[question], question
        assert gauge.at is None or inside(gauge) == (gauge.role == "right"), question


def test_a_hidden_mode_has_a_bar_below_the_line_of_rounding_and_the_others_reach_above_it() -> None:
    lesson = LESSONS["sandbox"].fit(canonical_text(Plant(np.diag([-1.0, -3.0]), np.ones((2, 1)), np.array([[1.0, 0.0]]))))
    figure = plane(lesson, lesson.compute(lesson.start()), "modes")
    *bars, line = figure.curves
    tops = {(float(bar.xs[0]) // 1, bar.name("en")): bar.y[1] > line.y[0] for bar in bars}
    assert sorted(above for (_, name), above in tops.items() if name == "seen by y") == [False, True]
    assert all(above for (_, name), above in tops.items() if name == "reached by u")


# --- duality -----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("sensor", [0.0, 37.0, 90.0])
def test_the_transposed_matrix_is_that_of_the_run_and_its_colours_are_mirrored(sensor: float) -> None:
    lesson, outcome = at("duality", sensor=sensor, poles=(-1.1 - 0.4j, -1.1 + 0.4j))
    figure, plant = shown(lesson, outcome, "turned"), outcome.run.scenario.plant
    own = plant.A - outcome.run.scenario.L @ plant.C
    assert figure.matrix == pytest.approx(np.hstack([own, own.T]), abs=1e-9)
    np.testing.assert_array_equal(figure.kinds[:, :2], figure.kinds[:, 2:].T)
    assert len(set(figure.kinds[:, :2].ravel())) == 3


@pytest.mark.parametrize("sensor", [0.0, 30.0, 90.0])
def test_the_pointer_of_the_sensor_shows_what_it_measures(sensor: float) -> None:
    """Its share along q and that along v are the two entries of C; the beam ends at the block."""
    _, outcome = at("duality", sensor=sensor)
    stage, C = outcome.stage, outcome.run.scenario.plant.C[0]
    assert stage is not None
    poses = stage.body.pose(stage.x[40].tolist(), stage.body.gain)
    w, x, y, z = poses["sensor pointer"].wxyz
    assert (2 * (x * z + w * y), 1 - 2 * (x * x + y * y)) == pytest.approx(tuple(C), abs=1e-9)
    beam, block = poses["sensor beam"], poses["block"]
    assert beam.position[0] - beam.scale[2] == pytest.approx(block.position[0] + 0.36)


@pytest.mark.parametrize("q", [0.01, 4.0, 100.0])
def test_both_bars_of_an_entry_are_equally_high(q: float) -> None:
    figure = plane(*at("duality", method="weights", q=q), "riccati")
    half = len(figure.curves) // 2
    left, right = ([float(bar.y[1]) for bar in bars] for bars in (figure.curves[:half], figure.curves[half:]))
    assert left == pytest.approx(right, rel=1e-9) and len(left) == len(figure.names) == 3
    assert all(figure.y_range[0] <= value <= figure.y_range[1] for value in left)


def test_output_energy_lies_on_the_mirror_image_where_the_task_is_solved() -> None:
    lesson = LESSONS["duality"]
    task = next(task for task in lesson.tasks if task.id == "mirror")
    for values, alike in (({}, False), (dict(task.solution), True)):
        figure = plane(*at("duality", **values), "mirrored")
        _, energy, mirror = figure.curves
        points = np.column_stack([energy.xs, energy.y]), np.column_stack([mirror.xs, mirror.y])
        away = max(float(np.min(np.linalg.norm(points[1] - point, axis=1))) for point in points[0])
        assert (away < 0.05 * figure.x_range[1]) == alike


# --- lqg ---------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("sigma", [5.0, 100.0, 1e4])
def test_the_line_to_minus_one_is_as_long_as_its_number_and_ends_on_the_curve(sigma: float) -> None:
    lesson, outcome = at("lqg", case="doyle", q=5.0, sigma=sigma)
    figure = plane(lesson, outcome, "nyquist")
    line = figure.curves[-1]
    end = complex(float(line.xs[1]), float(line.y[1]))
    assert (line.xs[0], line.y[0]) == (-1.0, 0.0) and abs(end + 1) == pytest.approx(outcome.metrics["nearest"], rel=1e-9)
    curve = figure.curves[2].xs + 1j * figure.curves[2].y
    assert np.abs(curve - end).min() < 0.02


def test_the_nyquist_figure_is_about_minus_one() -> None:
    for case in ("doyle", "platform"):
        figure = plane(*at("lqg", case=case), "nyquist")
        assert figure.x_range == (-2.0, 1.0)


@pytest.mark.parametrize("values", [{}, {"q": 100.0, "sigma": 100.0}, {"recovery": 4.0}, {"case": "platform"}])
def test_the_window_near_the_critical_point_holds_the_distance(values: dict[str, object]) -> None:
    lesson, outcome = at("lqg", **{"case": "doyle", **values})
    figure, near = plane(lesson, outcome, "closest"), outcome.study.real.margins.nearest
    bar = next(curve for curve in figure.curves if curve.role == "error")
    assert np.hypot(np.diff(bar.xs), np.diff(bar.y)).item() == pytest.approx(near)
    assert figure.x_range[0] <= bar.xs.min() and bar.xs.max() <= figure.x_range[1]
    assert figure.y_range[0] <= bar.y.min() and bar.y.max() <= figure.y_range[1]


# --- robust observer ---------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("choice", ["1", "2", "3", "4"])
def test_an_order_has_a_bar_or_a_circle_and_the_bar_is_the_share_of_the_table(choice: str) -> None:
    lesson, outcome = at("robust-observer", example=choice)
    figure, table = plane(lesson, outcome, "missed"), shown(lesson, outcome, "ranks")
    bars, circles = {int(bar.xs[0]): float(bar.y[1]) for bar in figure.curves}, {int(point.x) for point in figure.points}
    assert len(figure.names) == len(table.rows)
    for k, row in enumerate(table.rows):
        assert (k in circles) == (row[2] == row[3]) and (k in bars) != (k in circles)
        assert k not in bars or f"{bars[k]:.3g} %" == row[4]


@pytest.mark.parametrize("choice", ["1", "2", "3", "4"])
def test_the_error_that_stays_is_that_of_a_run_with_these_poles(choice: str) -> None:
    lesson, outcome = at("robust-observer", example=choice)
    figure, knob = plane(lesson, outcome, "steady"), EXAMPLE_CASES[choice].poles
    curve, now = figure.curves[0], outcome.design[knob]
    k = int(np.argmin(curve.y))
    assert (figure.points[0].x, figure.points[0].y) == (curve.xs[k], curve.y[k])
    for i in (len(curve.xs) // 2, len(curve.xs) // 3):
        by = curve.xs[i] - max(pole.real for pole in now)
        _, moved = at("robust-observer", example=choice, **{knob: tuple(pole + by for pole in now)})
        steady = moved.study.true.loop.steady()
        assert curve.y[i] == pytest.approx(min(steady, 1.5 * figure.y_range[1]))
        late = np.abs(moved.study.true.e[moved.study.true.t > 4.5]).max()
        assert late >= 0.95 * steady and (choice == "4" or late == pytest.approx(steady, rel=0.1))  # slow carts


# --- bilinear observer -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("problem", ["paper", "three", "three-fitting", "stuck"])
def test_the_terms_without_L_and_with_it_are_those_of_the_condition(problem: str) -> None:
    lesson, outcome = at("bilinear-observer", problem=problem)
    figure, o = plane(lesson, outcome, "terms"), PROBLEMS[problem].solved
    gain = o.L if o.L is not None else o.right @ np.linalg.pinv(o.Q)
    before, after = (np.abs(each).ravel() for each in (o.right, o.right - gain @ o.Q))
    bars = {(round(float(bar.xs[0]) + 1e-9), bar.xs[0] < round(float(bar.xs[0]))): float(bar.y[1]) for bar in figure.curves}
    if before.size == 3:
        for k in range(3):
            assert bars[k, True] == pytest.approx(before[k])
            assert bars.get((k, False), 0.0) == pytest.approx(after[k], abs=1e-8 * before.max())
    assert len(figure.points) == 3 - sum(not first for _, first in bars) and (o.case == 1) == (len(figure.points) < 3)


# --- record ------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("values", [{}, {"factor": 0.01}, {"factor": 100.0}, {"data": "furnace"}])
def test_nothing_of_nis_is_drawn_above_its_edge_and_what_is_larger_has_an_arrow(values: dict[str, object]) -> None:
    lesson, outcome = at("record", **values)
    figure, judged = plane(lesson, outcome, "nis"), outcome.study.judged
    top = figure.y_range[1]
    larger = int(np.count_nonzero(np.nan_to_num(judged.nis.values) / judged.nis.dof > top))
    assert figure.y_range[0] == 0.0 and (top == TOP if judged.mean_nis <= TOP else judged.mean_nis < top)
    assert all(np.all(curve.y <= top) for curve in figure.curves) and figure.curves[1].y[-1] == pytest.approx(judged.mean_nis)
    arrows = [point for point in figure.points if point.role == "error"]
    assert all(point.mark == "up" and point.y == top for point in figure.points)
    assert bool(arrows) == bool(larger) and len(arrows) <= larger
    assert (f"{larger} of" in figure.caption("en")) == bool(larger)


@pytest.mark.parametrize(("name", "figure"), [
    ("kalman", "tests"), ("sandbox", "numbers"), ("robust-observer", "missed"), ("robust-observer", "steady"),
    ("bilinear-observer", "terms"), ("lqg", "closest"), ("record", "nis")])
def test_the_figures_are_drawn_for_any_knobs(name: str, figure: str) -> None:
    lesson = LESSONS[name]
    for seed in range(3):
        rng = np.random.default_rng(seed)
        found = shown(*at(name, **{knob.name: at_random(knob, rng) for knob in lesson.knobs}), figure)
        assert found.table()[1] and found.title("zh") and found.caption("zh")
