"""Lessons on a person's own plant: whatever the plant, a finite picture or one sentence, never an exception of another kind."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import pytest
from all_plants import random_plant, wrong_on
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from laws import holds_for_all
from lesson_checks import boards_of, check_figures, check_mathml, complete, contents, every_lesson, numbers_of, others

from observer_lab.cli.entry import main
from observer_lab.course.knobs import KnobError, Poles
from observer_lab.course.lesson import Lesson, Stage
from observer_lab.engine import EngineError, Plant, Scenario, from_json, load_plant, simulate, to_json, to_mat
from observer_lab.lessons import LESSONS
from observer_lab.page.words.prose import mathml
from observer_lab.plants import spring_damper
from observer_lab.plants.examples import DATA, EXAMPLES, example
from observer_lab.plants.own_plant import canonical_text, own_model, plant_of
from observer_lab.session.state.saved_state import SavedState, read_state, write_state

ADAPTABLE = [lesson for lesson in LESSONS.values() if lesson.adapt is not None]
adaptable = pytest.mark.parametrize("lesson", ADAPTABLE, ids=[lesson.id for lesson in ADAPTABLE])
examples = pytest.mark.parametrize("name", EXAMPLES)
KINDS = ("dense", "stable", "diagonal", "integrators", "deaf", "blind", "half hidden", "through", "sampled", "units")


@st.composite
def plants(draw: st.DrawFn) -> str:
    """Plants of 1 to 30 states and 1 to 4 inputs and outputs, of kinds that break naive code."""
    kind, n = draw(st.sampled_from(KINDS)), draw(st.integers(1, 6) | st.integers(1, 30))
    m, p, seed = draw(st.integers(1, 4)), draw(st.integers(1, 4)), draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) * 10.0 ** rng.uniform(-3, 3)
    B, C, D, dt = rng.standard_normal((n, m)) * 10.0 ** rng.uniform(-3, 3), rng.standard_normal((p, n)), None, 0.0
    if kind == "stable":
        A = A - 1.5 * np.sqrt(n) * np.abs(A).max() * np.eye(n)
    elif kind == "diagonal":
        A = np.diag(-(10.0 ** rng.uniform(-4, 4, n)))
    elif kind == "integrators":
        A = np.diag(np.ones(n - 1), 1)
    elif kind == "deaf":
        B = np.zeros((n, m))
    elif kind == "blind":
        C = np.zeros((p, n))
    elif kind == "half hidden":
        A[:n // 2, n // 2:], C[:, n // 2:] = 0.0, 0.0
    elif kind == "through":
        D = rng.standard_normal((p, m))
    elif kind == "sampled":
        A, dt = A / max(np.abs(np.linalg.eigvals(A)).max(), 1e-9) * rng.uniform(0.3, 1.2), float(10.0 ** rng.uniform(-4, 2))
    elif kind == "units":
        scale = 10.0 ** rng.uniform(-5, 5, n)
        A, B, C = A * scale / scale[:, None], B / scale[:, None], C * scale
    return canonical_text(Plant(A, B, C, D, dt))


def opens(lesson: Lesson, plant: str) -> None:
    """A whole finite picture, or one sentence."""
    try:
        fitted = lesson.fit(plant)
        outcome = fitted.compute(fitted.start())
        figures = tuple(fitted.figures(outcome))
    except (EngineError, KnobError) as problem:
        assert str(problem).strip() and "\n" not in str(problem)
        return
    check_figures(figures)
    for name, values in numbers_of(outcome):
        assert np.all(np.isfinite(values)), name
    for board in outcome.boards:
        for pole in (*board.held, *board.fixed):
            assert board.re_low <= pole.real <= board.re_high and abs(pole.imag) <= board.im_high
        if board.knob is not None:
            knob = fitted.knob(board.knob)
            assert isinstance(knob, Poles) and (board.re_low, board.re_high, board.im_high) == (knob.re_low, knob.re_high, knob.im_high)
            fitted.apply(outcome.design, {board.knob: board.held, **dict(board.also)})


def test_a_run_lost_within_its_first_step_is_said_in_a_sentence() -> None:
    """Of such a run no more than its start is left, which no figure over time can show."""
    run = simulate(Scenario(Plant([[1e5]], [[1]], [[1]]), x0=[1.0], horizon=1.0))
    assert len(run.t) == 1
    with pytest.raises(KnobError, match="first step"):
        Stage(spring_damper.MODEL.body, run.t, run.x)


@pytest.mark.slow
@adaptable
@settings(max_examples=12, derandomize=True, database=None,
          suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(plant=plants())
def test_any_plant_gives_a_finite_picture_or_one_sentence(lesson: Lesson, plant: str) -> None:
    opens(lesson, plant)


@adaptable
def test_no_figure_contradicts_another(lesson: Lesson) -> None:
    """Two plants of those that the script runs through by the hundred."""
    assert {wrong_on(lesson, random_plant((2, k), sampled=k == 1, bilinear=lesson.bilinear)) for k in range(2)} <= {"", "refused"}


@settings(max_examples=60, derandomize=True, database=None)
@given(plant=plants())
def test_every_plant_becomes_a_model_whose_numbers_make_sense(plant: str) -> None:
    model = own_model(plant_of(plant))
    n = model.plant.n
    assert 0 < model.dt < model.horizon and round(model.horizon / model.dt) <= 500
    assert len(model.x0) == len(model.guess) == len(model.kick) == n and max(map(abs, model.x0)) == pytest.approx(1.0)
    assert np.all(np.isfinite([*model.kick, model.u_max])) and model.u_max > 0 and np.any(model.kick)
    assert all(len(signal.weights) == n for signal in model.watched) and len(model.watched) == n + model.plant.p
    poses = model.body.pose(model.x0, model.body.gain)
    assert {part.name for part in model.body.parts} == set(poses)
    assert all(abs(v) < 3 for pose in poses.values() for v in pose.position)
    for poles, window in ((model.controller_poles, model.controller_window), (model.observer_poles, model.observer_window)):
        assert all(p.conjugate() in poles for p in poles)
        assert all(window.re_low <= p.real <= window.re_high and abs(p.imag) <= window.im_high for p in poles)


@settings(max_examples=60, derandomize=True, database=None)
@given(plant=plants())
def test_the_canonical_text_is_its_own_canonical_text(plant: str) -> None:
    assert canonical_text(plant_of(plant)) == plant and from_json(plant) == plant_of(plant)


@lru_cache(maxsize=64)
def fitted(id: str, name: str) -> Lesson | None:
    """A lesson on an example plant, None where it does not fit."""
    try:
        return LESSONS[id].fit(example(name))
    except (EngineError, KnobError):
        return None


@adaptable
def test_an_adapted_lesson_is_the_same_lesson(lesson: Lesson) -> None:
    own = next(f for f in (fitted(lesson.id, name) for name in EXAMPLES) if f is not None)
    assert (own.id, own.number, own.answer, own.exams, own.kick) == (lesson.id, lesson.number, lesson.answer, lesson.exams, lesson.kick)
    assert own.start().plant == own.plant != "" and lesson.fit("") is lesson
    assert own.fit(own.plant) is lesson.fit(own.plant)
    for language, prose in own.words.items():
        assert prose.introduction.endswith(lesson.words[language].introduction)
        assert list(prose.tasks) == [task.id for task in lesson.tasks if task.id in {t.id for t in own.tasks}]


def is_complete_on(lesson: Lesson, name: str) -> None:
    """Words, formulas and tasks of a lesson on an example plant, where it fits."""
    own = fitted(lesson.id, name)
    if own is None:
        opens(lesson, example(name))
        return
    outcome = own.compute(own.start())
    figures = tuple(own.figures(outcome))
    complete(outcome.live, "live")
    for figure in figures:
        complete(figure.title, f"title of {figure.id}")
        complete(figure.caption, f"caption of {figure.id}")
    for formula in outcome.formulas:
        check_mathml(mathml(formula.latex, True), formula.id)
    for knob in own.knobs:
        complete(knob.label, f"label of {knob.name}")
        assert knob.hidden or knob.hint("en").strip(), knob.name
    for task in own.tasks:
        solved = own.compute(own.apply(own.start(), task.solution))
        assert not task.judge(outcome).solved
        assert task.judge(solved, task.typed.right(solved) if task.typed else "").solved
    assert {tab.tab("en") for tab in figures if sum(f.tab == tab.tab for f in figures) > 3} == set()


@pytest.mark.slow
@adaptable
def test_the_example_plants_open_everywhere_or_say_why_not(lesson: Lesson) -> None:
    holds_for_all(EXAMPLES, partial(is_complete_on, lesson))


def knobs_move_something_on(lesson: Lesson, name: str) -> None:
    """Every knob of a lesson on an example plant, where it fits; two of its values are looked at, more where they change nothing."""
    own = fitted(lesson.id, name)
    if own is None:
        return
    start = own.start()
    outcome = own.compute(start)
    ids, before = {f.id for f in own.figures(outcome)}, (contents(tuple(own.figures(outcome))), boards_of(outcome))
    for knob in own.knobs:
        if not own.shown(knob, start):
            continue
        changed = tried = 0
        for value in others(knob, start):
            if changed and tried > 1:
                break
            tried += 1
            try:
                new = own.compute(own.apply(start, {knob.name: value}))
                drawn = tuple(own.figures(new))
            except (EngineError, KnobError):
                continue
            check_figures(drawn)
            assert {f.id for f in drawn} == ids, knob.name
            changed += (contents(drawn), boards_of(new)) != before
        assert changed, knob.name


@pytest.mark.slow
@adaptable
def test_every_knob_of_an_adapted_lesson_does_something(lesson: Lesson) -> None:
    bilinear, linear = ("exchanger", "motor"), [name for name in EXAMPLES if name != "exchanger"]
    holds_for_all(bilinear if lesson.bilinear else linear, partial(knobs_move_something_on, lesson))


def job_works_on(lesson: Lesson, name: str) -> None:
    """The job of a lesson on an example plant, where it fits."""
    own = fitted(lesson.id, name)
    if own is None or own.job is None:
        return
    outcome = own.compute(own.start())
    before, fractions, last = contents(tuple(own.figures(outcome))), [], outcome
    try:
        for fraction, last in own.job.outcomes(outcome):
            fractions.append(fraction)
            if len(fractions) % 7 == 1:
                check_figures(tuple(own.figures(last)))
            if own.id in ("kalman", "lqg") and len(fractions) > 8:
                break  # a hundred records: dropped midway
    except (EngineError, KnobError) as problem:
        assert "\n" not in str(problem)
        return
    assert fractions == sorted(fractions) and contents(tuple(own.figures(last))) != before
    assert contents(tuple(own.figures(outcome))) == before
    if own.pick is not None:
        picked = own.apply(outcome.design, own.pick(last, 0.5, -0.5))
        assert own.job.key(picked) == own.job.key(outcome.design)


@pytest.mark.slow
@adaptable
def test_jobs_of_adapted_lessons_rise_to_their_end_or_can_be_dropped(lesson: Lesson) -> None:
    holds_for_all(("aircraft", "motor", "pendulum"), partial(job_works_on, lesson))


@every_lesson
def test_a_lesson_about_its_own_plant_refuses_others_in_both_languages(lesson: Lesson) -> None:
    if lesson.adapt is None:
        with pytest.raises(KnobError) as problem:
            lesson.fit(example("motor"))
        complete(problem.value.text, "refusal")


# --- files and the command line ----------------------------------------------------------------------------------------
def test_a_design_with_a_plant_travels_as_a_state_file() -> None:
    motor = plant_of(example("motor"))
    own = LESSONS["separation"].fit(canonical_text(replace(motor, name="My motor")))
    design = own.apply(own.start(), {"mismatch": 7.0})
    text = write_state(LESSONS["separation"], SavedState(design))
    assert json.loads(text)["plant"]["name"] == "My motor"
    assert read_state(text, LESSONS).design == design == read_state(write_state(own, SavedState(design)), LESSONS).design


@pytest.mark.parametrize("plant", [3, [], {}, {"A": [[1]]}, {"A": [[float("nan")]], "B": [[1]], "C": [[1]]}, "x" * 1000])
def test_a_state_file_with_a_torn_plant_is_refused(plant: object) -> None:
    data = json.loads(write_state(LESSONS["separation"], SavedState(LESSONS["separation"].start()))) | {"plant": plant}
    with pytest.raises(KnobError) as problem:
        read_state(json.dumps(data), LESSONS)
    assert "\n" not in str(problem.value)


def test_run_takes_a_plant_from_json_from_mat_and_by_name(capsys, tmp_path: Path) -> None:
    plant = load_plant(DATA / "motor.json")
    to_mat(plant, tmp_path / "motor.mat")
    (tmp_path / "motor.json").write_text(to_json(plant), encoding="utf-8")
    found = []
    for words in (str(tmp_path / "motor.json"), str(tmp_path / "motor.mat"), "motor"):
        assert main(["run", "error-dynamics", "--json", "--plant", words, "--set", "amplitude=0"]) in (0, 1)
        found.append(json.loads(capsys.readouterr().out))
    assert found[0] == found[1] == found[2]
    assert found[0]["plant"]["A"] == plant.A.tolist() and np.shape(found[0]["gains"]["L"]) == (4, 1)
    state = tmp_path / "state.json"
    start = LESSONS["error-dynamics"].fit(example("motor")).start()
    state.write_text(write_state(LESSONS["error-dynamics"], SavedState(start)), encoding="utf-8")
    assert main(["run", "error-dynamics", "--json", "--state", str(state), "--set", "amplitude=0"]) in (0, 1)
    assert json.loads(capsys.readouterr().out) == found[0]


@pytest.mark.parametrize("content, name", [
    (b"", "p.json"), (b"{", "p.json"), (b"\xff", "p.json"), (b"{}", "p.json"), (b"x" * 1_000_001, "p.json"), (b"torn", "p.mat"),
    (b"{}", "p.txt"), (None, "nowhere.json"),
    (json.dumps({"A": [[-1]], "B": [[1]], "C": [[1, 2]]}).encode(), "p.json"),
    (json.dumps({"A": [[-0.5]], "B": [[1]], "C": [[1], [2, 3]]}).encode(), "p.json"),
])
@pytest.mark.parametrize("command", [["run", "separation"], ["serve", "--lesson", "separation"]])
def test_a_plant_file_that_cannot_be_used_is_status_2_and_one_sentence(content, name, command, capsys, tmp_path: Path) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    assert main([*command, "--plant", str(tmp_path / name)]) == 2
    out, err = capsys.readouterr()
    assert out == "" and len(err.splitlines()) == 1 and err.startswith("observer-lab: ") and err.rstrip().endswith(".")


def test_a_lesson_that_takes_no_plant_and_two_sources_of_one_are_status_2(capsys, tmp_path: Path) -> None:
    assert main(["run", "decoupling", "--plant", "motor"]) == 2
    assert "its own plant" in capsys.readouterr().err
    for command in (["run"], ["export", "--to", "json"], ["link"], ["replay"]):
        assert main([command[0], "separation", *command[1:], "--plant", "motor", "--state", "x.json"]) == 2
        assert "not both" in capsys.readouterr().err


@examples
def test_the_example_files_are_small_name_their_source_and_lose_nothing(name: str) -> None:
    file = DATA / EXAMPLES[name].file
    assert file.stat().st_size < 5000
    plant = load_plant(file)
    assert plant.name and set(dict(plant.units)) >= set(plant.state_names) | set(plant.input_names) | set(plant.output_names)
    said = (DATA / "README.md").read_text(encoding="utf-8")
    assert file.name in said
    if file.suffix == ".json":
        assert len(json.loads(file.read_text(encoding="utf-8"))["source"]) > 60
    assert plant_of(example(name)) == plant, "a name of this plant does not pass the gate unchanged"
