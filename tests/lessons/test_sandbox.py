"""Sandbox: every analysis or one clear sentence why not, and none of them takes another with it."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest
from lesson_checks import carried
from scipy.linalg import solve_discrete_are
from scipy.spatial.transform import Rotation

from observer_lab.course.figures.records import TableFigure
from observer_lab.course.lesson import Lesson, Outcome
from observer_lab.engine import Plant, closed_loop, controllability, hankel_singular_values, loop_margins, observability
from observer_lab.engine.design import in_natural_units
from observer_lab.engine.filters.linear.filter_trial import simulate_filter
from observer_lab.lessons.sandbox.analyses import ASSUMED_NOISE_RATIOS, RECORD_SAMPLES, UNTESTED_SAMPLES, Refusal, noises, trial
from observer_lab.lessons.sandbox.lesson import LESSON
from observer_lab.lessons.sandbox.number_bars import body_of, decades_of
from observer_lab.lessons.sandbox.questions import grouped
from observer_lab.plants.examples import EXAMPLES, example
from observer_lab.plants.own_plant import canonical_text, own_model, plant_of


def opened(plant: Plant | str, **changes: object) -> tuple[Lesson, Outcome]:
    lesson = LESSON.fit(plant if isinstance(plant, str) else canonical_text(plant))
    return lesson, lesson.compute(lesson.apply(lesson.start(), changes))


def lights(lesson: Lesson, outcome: Outcome) -> dict[str, str]:
    table = next(f for f in lesson.figures(outcome) if f.id == "lights")
    assert isinstance(table, TableFigure)
    return {name("en"): verdict("en") for name, verdict, _ in table.rows}  # type: ignore[union-attr]


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_numbers_are_those_of_the_engine_asked_directly(name: str) -> None:
    plant, (_, outcome) = plant_of(example(name)), opened(example(name))
    study, K, L = outcome.study, outcome.gains["K"], outcome.gains["L"]
    assert study.structure.seen.rank == observability(plant).rank and study.structure.reached.rank == controllability(plant).rank
    assert np.array_equal(outcome.poles["loop"], closed_loop(plant, K, L).poles)
    assert study.loop.stable
    if np.all(np.abs(plant.poles) < 1 if plant.dt else plant.poles.real < 0):
        assert study.structure.hankel == pytest.approx(hankel_singular_values(plant), rel=1e-6, abs=1e-12)
    if not isinstance(study.margins, Refusal):
        assert study.margins.together == loop_margins(plant, study.loop.compensator).all_inputs.disk.alpha


def test_one_failing_analysis_leaves_the_others_alone() -> None:
    """Deaf, blind and unstable: no filter, no margins, no Hankel values; yet structure, loop and run are there."""
    lesson, outcome = opened(Plant(np.diag([1.0, 2.0]), np.zeros((2, 1)), np.zeros((1, 2))))
    study = outcome.study
    assert all(isinstance(answer, Refusal) for answer in (study.structure.hankel, study.noise, study.trial, study.margins))
    for answer in (study.structure.hankel, study.noise, study.trial, study.margins):
        assert answer.text("en").strip() and answer.text("zh").strip() and "\n" not in answer.text("en")
    shown = lights(lesson, outcome)
    assert shown["observable"] == shown["detectable"] == shown["controllable"] == shown["stabilizable"] == "○ no"
    assert shown["Kalman filter consistent"] == shown["robust at the inputs (α ≥ 0.5)"] == "— not here"
    assert outcome.run is not None and len(outcome.run.t) > 30
    captions = {f.id: f.caption("en") for f in lesson.figures(outcome)}
    for name in ("hankel", "valley", "nis", "gain", "sensitivity", "margins"):
        assert captions[name].startswith("Not with this design: "), name


def test_lights_of_hidden_stable_and_hidden_unstable() -> None:
    for fast, detectable in ((-3.0, "● yes"), (3.0, "○ no")):
        lesson, outcome = opened(Plant(np.diag([-1.0, fast]), np.ones((2, 1)), np.array([[1.0, 0.0]])))
        shown = lights(lesson, outcome)
        assert shown["observable"] == "○ no" and shown["detectable"] == detectable and shown["controllable"] == "● yes"
        assert shown["minimal"] == "○ no"
        assert (fast in outcome.boards[1].fixed) == (abs(fast) < 10)


def test_a_sampled_plant_is_taken_as_it_is() -> None:
    lesson, outcome = opened(example("pendulum"))
    plant = plant_of(example("pendulum"))
    assert np.all(np.abs(outcome.poles["loop"]) < 1) and all(board.disc for board in outcome.boards)
    assert outcome.run is not None and np.diff(outcome.run.t) == pytest.approx(plant.dt)
    x = outcome.run.x
    assert x[1:] == pytest.approx(x[:-1] @ plant.A.T + outcome.run.u_applied[:-1] @ plant.B.T, abs=1e-9)
    assert lesson.job is not None
    with pytest.raises(Exception, match="continuous"):
        next(lesson.job.outcomes(outcome))


def test_told_the_applied_input_the_error_lives_by_itself_through_the_limit() -> None:
    for name in ("aircraft", "motor", "pendulum"):
        limit = {"limited": True, "u_max": 1.6 * own_model(plant_of(example(name))).u_max}
        for fed, alone in (("applied", True), ("commanded", False)):
            _, outcome = opened(example(name), fed=fed, **limit)
            assert outcome.metrics["clipped_share"] > 0
            assert (outcome.metrics["separation_meter"] < 1e-8) == alone


@pytest.mark.slow
def test_the_expected_nis_is_what_many_records_average() -> None:
    model = own_model(plant_of(example("pendulum")))
    for belief in (0.1, 1.0, 10.0):
        many = [trial(model, 0.01, belief, seed) for seed in range(1, 41)]
        mean, spread = np.mean([t.test.mean for t in many]), np.std([t.test.mean for t in many]) / np.sqrt(len(many))
        assert abs(mean - many[0].expected) < 4 * spread + 0.01
    assert trial(model, 0.01, 1.0, 1).expected == pytest.approx(2.0, rel=1e-6)


def test_an_unstable_loop_that_clips_keeps_no_error_below_its_peak() -> None:
    """A limit cycle is quiet for seconds and then clips again; the observer is told of what was asked."""
    loop = {"controller_poles": (-3.6 + 1.9j, -3.6 - 1.9j, 0.345 + 1.99j, 0.345 - 1.99j), "limited": True, "u_max": 0.19, "kick": 12.13,
            "observer_poles": (-13.8 + 1.3j, -13.8 - 1.3j, -9 + 2.1j, -9 - 2.1j)}
    for fed in ("commanded", "applied"):
        outcome = LESSON.compute(LESSON.apply(LESSON.start(), {**loop, "fed": fed}))
        caption = next(f.caption("en") for f in LESSON.figures(outcome) if f.id == "error")
        assert ("nothing keeps it" in caption or "does not settle" in caption) == (fed == "commanded"), caption


def test_the_nis_of_the_words_is_that_of_a_filter_written_out_by_hand() -> None:
    """1.66, 0.41 and 9.1: the record of the start through Kalman's two steps, with a plant and noise sampled by a Taylor series."""
    model = own_model(plant_of(example("aircraft")))
    A, B, C, h = model.plant.A, model.plant.B, model.plant.C, model.horizon / RECORD_SAMPLES
    G, W, V = noises(model, 0.01)
    record = simulate_filter(model.plant, G, W, V, h, RECORD_SAMPLES, seed=int(LESSON.start()["seed"])).run
    powers = [np.linalg.matrix_power(A, k) * h**k / factorial(k) for k in range(25)]
    F, H = sum(powers), sum(p * h / (k + 1) for k, p in enumerate(powers)) @ B
    Q = sum(p @ G @ W @ G.T @ q.T * h / (i + j + 1) for i, p in enumerate(powers) for j, q in enumerate(powers))
    R = V / h
    P0 = 4 * solve_discrete_are(F.T, C.T, Q, R)
    for belief, said in ((1.0, "1.66"), (1000.0, "0.41"), (0.001, "9.1")):
        x, P, nis = np.zeros(model.plant.n), P0, []
        for y, u in zip(record.y, record.u_applied, strict=True):
            nu, S = y - C @ x, C @ P @ C.T + R
            M = P @ C.T @ np.linalg.inv(S)
            nis.append(nu @ np.linalg.solve(S, nu))
            x, P = F @ (x + M @ nu) + H @ u, F @ (P - M @ S @ M.T) @ F.T + belief * Q
        assert f"{np.mean(nis[UNTESTED_SAMPLES:]):.{len(said) - 2}f}" == said
        assert all(said in prose.again.question + prose.again.reveal for prose in LESSON.words.values())


def test_the_bottom_of_the_valley_is_the_true_belief() -> None:
    for name in ("aircraft", "pendulum", "tanks"):
        _, outcome = opened(example(name))
        found = outcome.study.noise
        sizes = [np.trace(part.total / np.outer(found.unit, found.unit)) for part in found.ladder.parts]
        assert ASSUMED_NOISE_RATIOS[int(np.argmin(sizes))] == pytest.approx(1.0)


def test_recovery_brings_the_margin_of_a_minimum_phase_plant_back() -> None:
    lesson, outcome = opened(example("tanks"))
    assert lesson.job is not None
    *_, (fraction, last) = lesson.job.outcomes(outcome)
    q, alpha, target = zip(*last.study.steps, strict=True)
    assert fraction == 1.0 and list(q) == sorted(q)
    assert alpha[-1] > 0.9 * target[-1] and alpha[-1] > alpha[0] - 1e-9


def test_what_was_recovered_stays_while_only_the_observer_moves() -> None:
    lesson, start = opened(example("tanks"))
    assert lesson.job is not None
    *_, (_, found) = lesson.job.run(start)
    assert found is not None and len(found.steps) > 1
    observer = lesson.compute(lesson.apply(start.design, {"tolerance": 1e-3}))
    assert carried(lesson, start.design, found, observer).study.steps == found.steps
    moved = lesson.apply(start.design, {"controller_poles": [1.2 * p for p in start.design["controller_poles"]]})
    assert not carried(lesson, start.design, found, lesson.compute(moved)).study.steps


@pytest.mark.parametrize("controller", [(-3.0, -1.0, 0.0, 0.0), (-1.0, 0.0, 0.0, 0.0), (-2.0, -1.0, -0.5, 0.0)], ids=str)
def test_poles_asked_for_on_the_axis_leave_no_margins_and_no_warning(controller: tuple[float, ...]) -> None:
    """Rounding puts such a pole a hair to the left on one processor and to the right on another; S is infinite beside it."""
    poles = {"controller_poles": tuple(map(complex, controller)), "observer_poles": (-5.75 + 0j, -3 + 0j, -1 + 0j, 0j)}
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), poles))
    assert LESSON.figures(outcome) and outcome.live("en")


def test_the_margin_is_spent_by_weights_and_by_poles_and_the_observer_keeps_to_its_share() -> None:
    """The task's numbers both ways; neither a margin alone nor an observer alone will do."""
    task = next(t for t in LESSON.tasks if t.id == "spent-margin")
    quick = (-3.0 + 0j, -1.5 - 1.5j, -1.5 + 1.5j, -1.5 + 0j)
    said = [task.check(LESSON.compute(LESSON.apply(LESSON.start(), changes))) for changes in (
        {"method": "weights", "q": 0.5, "w": 3.0, "v": 1.0}, {"method": "weights", "q": 50.0, "r": 100.0, "w": 0.03},
        {"controller_poles": quick}, {"controller_poles": quick, "sensor": 0.1}, {}, {"method": "weights", "q": 5.0, "w": 3.0, "v": 1.0})]
    assert [v.solved for v in said] == [True, True, True, False, False, False]
    assert [v.text("en") for v in said[:5:2]] == [
        "Disk margin 1.01, and an error of 1.05 times the least.", "Disk margin 1.03, and an error of 1.07 times the least.",
        "Disk margin 1.47; 1.0 within 5 % is wanted."]


def test_the_bars_before_the_plant_are_gain_disk_margin_and_nis_over_the_expected_with_rings_at_the_start() -> None:
    """A bar is log₁₀ of its number, from a tenth to a hundred, 3.2 long; its words are that number, as in card and formula."""
    start = LESSON.start()
    first, fast, wrong = (LESSON.compute(design) for design in (
        start, LESSON.apply(start, {"observer_poles": (-7.18, -6.87, -5 - 2j, -5 + 2j)}), LESSON.apply(start, {"belief": 1000.0})))
    for outcome in (first, fast, wrong):
        stage, k = outcome.stage, 30
        assert stage is not None and stage.xhat is not None and stage.body.marks is not None
        numbers = np.abs(outcome.gains["L"]).max(), outcome.metrics["disk_margin"], np.mean(outcome.study.trial.values[20:]) / 2
        begun = np.abs(first.gains["L"]).max(), first.metrics["disk_margin"], np.mean(first.study.trial.values[20:]) / 2
        poses = stage.body.pose(stage.x[k].tolist(), 1.0)
        long = [poses[f"bar {j}"].scale[2] for j in range(3)]
        np.testing.assert_allclose(long, 3.2 * np.clip((np.log10(numbers) + 1) / 3, 0.004, 1), rtol=1e-6)
        said = [float(words) for words, *_ in stage.body.marks(stage.x[k].tolist(), stage.xhat[k].tolist(), 1.0).words]
        np.testing.assert_allclose(said, numbers, rtol=5e-3)
        for j in range(3):  # the rings are where the bars end at the start
            along = poses[f"start {j}"].position[0] - poses[f"bar {j}"].position[0]
            assert along == pytest.approx(3.2 * (np.log10(begun[j]) + 1) / 3)
        marks = [words("en") for words, _ in stage.body.labels if words("en") in ("0.1", "1", "10", "100")]
        assert marks == ["0.1", "1", "10", "100"]


def test_the_bars_of_every_plant_have_room_about_what_they_begin_with() -> None:
    for name in EXAMPLES:
        model = own_model(plant_of(example(name)))
        low, high = decades_of(model)
        assert model.observer is not None and low <= -1 and high >= 2, name
        assert 10.0**low < np.abs(model.observer.gain).max() < 10.0**high, name


def test_the_dots_of_the_question_are_means_of_seven_values_of_nis_over_the_two_expected() -> None:
    """Without the first twenty samples; the filter that assumes 1000 times the noise lies far below as the record goes on."""
    start = LESSON.start()
    now, after = (LESSON.compute(LESSON.apply(start, {"belief": belief})) for belief in (1.0, 1000.0))
    for outcome in (now, after):
        t, means = grouped(outcome.study.trial)
        values = outcome.study.trial.values
        assert len(means) == (len(values) - 20) // 7 == 20
        by_hand = [sum(values[20 + 7 * k:27 + 7 * k]) / 7 / 2 for k in range(20)]
        np.testing.assert_allclose(means, by_hand)
        assert t[0] == pytest.approx(np.mean(outcome.study.trial.t[20:27]))
        assert np.mean(means) == pytest.approx(outcome.metrics["nis_share"], rel=0.05)


def test_the_aircraft_banks_and_turns_its_nose_as_the_tubes_say_and_stands_on_no_other_plant() -> None:
    """Seen from behind, right wing down at a positive bank angle; the nose to the left of the flight at a positive sideslip."""
    stage = LESSON.compute(LESSON.start()).stage
    assert stage is not None
    parts = {part.name: part for part in stage.body.parts}
    assert parts["wings"].twin and "wings" not in {part.name for part in body_of(own_model(plant_of(example("motor")))).parts}
    level, rest = (stage.body.pose([0.0] * 4 + [0.5] * 3, 1.0) for _ in range(2))

    def turned(name: str, way: tuple[float, float, float], **states: float) -> np.ndarray:
        x = [states.get(each, 0.0) for each in ("sideslip", "roll", "yaw", "bank")]
        pose = stage.body.pose([*x, 0.5, 0.5, 0.5], 1.0)[name]
        return Rotation.from_quat(np.roll(pose.wxyz, -1)).apply(way)

    assert level == rest and np.allclose(turned("wings", (1, 0, 0)), (1, 0, 0))
    right = turned("wings", (1, 0, 0), bank=0.1)
    nose = turned("fuselage", (0, 1, 0), sideslip=0.1)
    assert right[2] < -0.05 and right[1] == pytest.approx(0, abs=1e-12)
    assert nose[0] < -0.05 and nose[2] == pytest.approx(0, abs=1e-12)
    assert turned("wings", (1, 0, 0), bank=0.2)[2] < right[2] < turned("wings", (1, 0, 0), bank=-0.1)[2]
    assert np.allclose(turned("wings", (1, 0, 0), roll=0.3, yaw=0.3), (1, 0, 0))


@pytest.mark.parametrize(("tolerance", "counted"), [(1e-12, 4), (0.01, 4), (0.29, 3), (0.5, 2)])
def test_the_columns_above_the_plate_are_the_singular_values_above_the_tolerance(tolerance: float, counted: int) -> None:
    """σ of [C; CA; CA²; CA³] in natural units, over the largest: 1.75 long at 1, none at 0.01; the plate is as high as τ."""
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"columns": True, "tolerance": tolerance}))
    stage, plant = outcome.stage, in_natural_units(outcome.study.model.plant)
    assert stage is not None and stage.body.marks is not None
    values = np.linalg.svd(np.vstack([plant.C @ np.linalg.matrix_power(plant.A, k) for k in range(4)]), compute_uv=False)
    shares, state = values / values[0], stage.x[30].tolist()
    poses = stage.body.pose(state, 1.0)
    columns = [poses[f"column {k}"] for k in range(4)]
    np.testing.assert_allclose([each.scale[2] for each in columns], 1.75 * (1 + np.log10(shares) / 2), rtol=1e-6)
    assert poses["tolerance"].position[2] - columns[0].position[2] == pytest.approx(1.75 * max(1 + np.log10(tolerance) / 2, 0), abs=1e-9)
    assert [each.colour == columns[0].colour for each in columns] == (shares > tolerance).tolist()
    assert sum(shares > tolerance) == counted == outcome.study.structure.seen.matrix_rank(tolerance)
    *sizes, said = (words for words, *_ in stage.body.marks(state, state, 1.0).words)
    np.testing.assert_allclose([float(words) for words in sizes], shares, rtol=5e-3)
    assert said.startswith("τ = ") and all(poses[f"tube {k}"].position[2] < -1 for k in range(4))


def test_the_columns_of_other_plants_are_as_many_as_their_states() -> None:
    for name in EXAMPLES:
        lesson = LESSON.fit(example(name))
        stage = lesson.compute(lesson.apply(lesson.start(), {"columns": True})).stage
        assert stage is not None
        columns = sum(part.name.startswith("column ") and part.name[7:].isdigit() for part in stage.body.parts)
        n = own_model(plant_of(example(name))).plant.n
        assert stage.xhat is None or columns == (n if n <= 10 else 0), name
        poses = stage.body.pose(stage.x[0].tolist(), stage.body.gain)
        assert {part.name for part in stage.body.parts} <= set(poses), name
