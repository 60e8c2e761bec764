"""The bilinear observer on a person's own plant: through the door, in any units, and one sentence where a condition fails."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from claim_trials import tried
from scipy.integrate import solve_ivp
from scipy.io import savemat
from test_all_derivations import broken

from observer_lab.cli.entry import main
from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Lesson, Outcome
from observer_lab.engine import EngineError, Plant
from observer_lab.lessons import LESSONS
from observer_lab.lessons.bilinear_observer.lesson import LESSON
from observer_lab.plants.examples import example
from observer_lab.plants.own_plant import canonical_text, clean_plant_json, read_plant_file
from observer_lab.plants.plant_extras import PlantExtras
from observer_lab.session.state.saved_state import SavedState, read_state, write_state
from observer_lab.session.state.token import read_token, write_token

# n, m, r, inputs, and the case that is to be expected
SHAPES = ((7, 5, 1, 1, 3), (8, 5, 2, 1, 3), (5, 3, 1, 1, 2), (6, 2, 1, 1, 1), (9, 7, 2, 1, 3), (6, 5, 1, 3, 3), (7, 5, 1, 2, 2))
SMALL = {"A": [[-1, 0.4, 0], [0.2, -2, 0.5], [0, 0.7, -3]], "B": [[1], [0], [1]], "C": [[1, 0, 0], [0, 1, 0]],
         "F": [[0.1, 0, 0.3], [0, 0.2, 0.1], [0, 0, -0.2]], "K": [[0, 0, 1]]}


def outcome(lesson: Lesson, **changes: object) -> Outcome:
    return lesson.compute(lesson.apply(lesson.start(), changes))


def random_plant(seed: int, shape: tuple[int, int, int, int], decades: float) -> str:
    """A stable bilinear plant of one input or several, each of its signals and time in a unit up to 10^±decades away."""
    (n, m, r, k), rng = shape, np.random.default_rng([seed, 16])
    A = rng.standard_normal((n, n))
    A -= (0.5 + np.linalg.eigvals(A).real.max()) * np.eye(n)
    B, F, C, K = (rng.standard_normal(size) for size in ((n, k), (n, k * n), (m, n), (r, n)))
    X, Y, S, U = (10 ** rng.uniform(-decades, decades, count) for count in (n, m, r, k))
    tau = 10 ** rng.uniform(-decades / 2, decades / 2)
    return canonical_text(Plant(tau * A * X / X[:, None], tau * B * U / X[:, None], C * X / Y[:, None]),
                     PlantExtras(tau * F * np.kron(U, X) / X[:, None], K * X / S[:, None]))


@pytest.mark.slow
def test_what_the_page_says_of_random_plants_is_so() -> None:
    """The case that counting leads to expect, the law of the error and every claim: every other plant in units up to 10^±6 away."""
    for seed, (n, m, r, k, case) in enumerate(SHAPES):
        own = LESSON.fit(random_plant(seed, (n, m, r, k), 6.0 * (seed % 2 == 0)))
        found = [outcome(own, **change) for change in ({}, {"input": "square", "form": "exact"}, {"noise": 1.0})]
        held = {c.id: c.holds for c in found[0].checks}
        assert (held["case1"], held["case2"], held["case3"]) == tuple(case == k for k in (1, 2, 3)), (seed, found[0].live)
        assert held["fewer"] == (r < n - m) and held["advised"] == ((k + 2) * m + r >= (k + 1) * n)
        for one in found[:2]:
            assert {c.id: c.holds for c in one.checks}["law"] == (case != 1), (seed, one.metrics["law_gap"])
        assert not [line for one in found for line in broken(own, one)], seed
        told = tried(own, [one.design for one in found])
        assert not told.lies and not told.unseen, (seed, told.lies, told.unseen)


def test_the_run_is_that_of_an_adaptive_solver() -> None:
    """Plant and observer from the file's matrices and the three matrices of (18) alone, g of two rows."""
    own = LESSON.fit(example("exchanger"))
    shown = outcome(own)
    form, run, file = shown.study.setting.plain, shown.study.run, json.loads(example("exchanger"))
    A, B, F, C, K = (np.array(file[k]) for k in "ABFCK")
    u0, omega = shown.design["amplitude"], shown.design["omega"]

    def rate(t: float, s: np.ndarray) -> np.ndarray:
        x, z, u = s[:9], s[9:], u0 * np.sin(omega * t)
        y = C @ x
        return np.concatenate([A @ x + u * (B[:, 0] + F @ x), form.A @ z + form.Y @ y + u * (form.B[:, 0] + form.U @ y)])
    at = [100, 250, 400]
    peer = solve_ivp(rate, (0, run.t[-1]), np.concatenate([run.x[0], [0, 0]]), "DOP853", run.t[at], rtol=1e-10, atol=1e-12).y.T
    np.testing.assert_allclose(run.x[at], peer[:, :9], rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(run.estimates[at, 0], peer[:, :9] @ C.T @ form.G_y.T + peer[:, 9:] @ form.G_z.T, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(run.g, run.x @ K.T, rtol=1e-9, atol=1e-12)
    assert shown.metrics["order"] == 2 and np.allclose(np.linalg.eigvals(form.A).real.max(), shown.metrics["slowest"])


# --- the door ----------------------------------------------------------------------------------------------------------
def test_json_and_mat_say_the_same_and_come_back_whole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = json.dumps(SMALL)
    text = read_plant_file("mine.json", words.encode())
    savemat(tmp_path / "mine.mat", {key: np.array(value, dtype=float) for key, value in SMALL.items()})
    assert read_plant_file("mine.mat", (tmp_path / "mine.mat").read_bytes()) == text == clean_plant_json(text) == clean_plant_json(words)
    assert json.loads(text)["F"] == SMALL["F"] and json.loads(text)["K"] == SMALL["K"]
    (tmp_path / "mine.json").write_text(words, encoding="utf-8")
    start = LESSON.fit(text).start()
    for back in (read_token(write_token(LESSON, SavedState(start)), LESSONS), read_state(write_state(LESSON, SavedState(start)), LESSONS)):
        assert back.design == start and "F" in json.loads(back.design.plant)
    told = []
    for name in ("mine.json", "mine.mat"):
        assert main(["run", LESSON.id, "--json", "--plant", str(tmp_path / name)]) in (0, 1)
        told.append(json.loads(capsys.readouterr().out))
    assert told[0] == told[1] and told[0]["plant"]["F"] == SMALL["F"] and told[0]["checks"]


def test_elsewhere_the_plant_is_the_linear_one_and_the_page_says_so() -> None:
    for id, own in (("separation", "left out"), ("sandbox", "left out"), (LESSON.id, "")):
        head = {language: LESSONS[id].fit(example("exchanger")).words[language].introduction.split("\n")[0] for language in ("en", "zh")}
        assert (own in head["en"]) and ("略去" in head["zh"]) == bool(own)


@pytest.mark.parametrize(("change", "words"), [
    ({"F": [[1, 2]]}, "F must be 3×3"), ({"F": "x"}, "F must be a list"), ({"F": [[1e999] * 3] * 3}, "finite"),
    ({"K": [[1, 2]]}, "rows of 3 numbers"), ({"K": [[1, 0, 0]]}, "read from y directly"), ({"K": [[0, 0, 0]]}, "zero"),
    ({"dt": 0.1}, "continuous time"), ({"B": [[1, 0], [0, 1], [1, 1]]}, "give F1 to F2"),
    ({"F": None, "F1": [[1, 2]]}, "F1 must be 3×3"), ({"D": [[1], [0]]}, "leave out D"),
    ({"C": [[1, 0, 0], [2, 0, 0]]}, "depend on each other"), ({"C": np.eye(3).tolist()}, "nothing is left to observe"),
])
def test_what_does_not_fit_is_one_sentence_in_both_languages(change: dict[str, object], words: str) -> None:
    with pytest.raises((EngineError, KnobError)) as problem:
        LESSON.fit(read_plant_file("mine.json", json.dumps(SMALL | change).encode()))
    said = str(problem.value)
    assert words in said and said.endswith(".") and said.count(". ") == 0 and "\n" not in said


def test_where_a_condition_fails_the_sentence_says_which_and_what_to_change() -> None:
    blind = json.loads(example("exchanger")) | {"D": None}
    blind["C"], blind["outputs"] = blind["C"][:3], blind["outputs"][:3]
    stuck = SMALL | {"A": np.diag([-1.0, -2.0, 3.0]).tolist(), "F": np.zeros((3, 3)).tolist()}
    lone = {"A": [[-1, 1], [0, 2]], "B": [[1], [0]], "C": [[1, 0]], "F": [[0, 1], [0, 0.5]], "K": [[0, 1]]}  # L = 0.5, the pole 2 − L
    for plant, which, change in ((blind, "(21) fails", "measure more, or want another g"), (stuck, "stays put", "Measure other states"),
                                 (lone, "its pole 1.5 is not on the left", "Measure more, or want another g")):
        live = outcome(LESSON.fit(read_plant_file("mine.json", json.dumps(plant).encode()))).live
        assert which in live("en") and change in live("en") and live("zh").endswith("。")


def test_without_f_the_page_says_so_and_a_k_of_another_kind_is_no_concern_of_ours() -> None:
    matrices = {key: SMALL[key] for key in "ABC"}
    assert "F is zero" in LESSON.fit(canonical_text(Plant(*matrices.values()))).words["en"].introduction
    assert read_plant_file("gain.json", json.dumps(matrices | {"K": [[1, 2]]}).encode()) == canonical_text(Plant(*matrices.values()))


def test_at_u_zero_an_error_that_u_would_drive_is_not_said_to_be_free_of_it() -> None:
    """(21) fails through F alone, so with u = 0 the error of the nearest L has a law of its own."""
    driven = {"A": [[-1, 1, 0], [0, -2, 0], [0, 0, -3]], "C": [[1, 0, 0]], "F": [[0, 0, 0], [0, 0, 1], [0, 0, 0]], "K": [[0, 1, 0]]}
    own = LESSON.fit(clean_plant_json(json.dumps(SMALL | driven)))
    still = outcome(own, input="none")
    assert still.metrics["law_gap"] < 1e-9 and still.metrics["case"] == 1
    assert next(f for f in own.figures(still) if f.id == "error").caption("en").startswith("No L frees")


def test_rows_that_follow_from_others_are_not_counted_in_r() -> None:
    own = LESSON.fit(clean_plant_json(json.dumps(SMALL | {"K": [[0, 0, 1], [1, 0, 1]]})))
    assert "the 2 numbers wanted have rank 1" in next(f for f in own.figures(outcome(own)) if f.id == "conditions").caption("en")


def test_each_of_several_inputs_has_a_matrix_and_a_drive_of_its_own(tmp_path: Path) -> None:
    """F1 and F2 in JSON and .mat are one plant; the run of both drives is that of an adaptive solver; a matrix left out is zero."""
    two = {key: SMALL[key] for key in "AC"} | {"B": [[1, 0], [0, 1], [1, 1]], "K": [[0, 0, 1]], "F1": SMALL["F"],
                                               "F2": [[0, 0.2, 0], [0, 0, 0.1], [0.3, 0, 0]]}
    words = read_plant_file("two.json", json.dumps(two).encode())
    savemat(tmp_path / "two.mat", {key: np.array(value, dtype=float) for key, value in two.items()})
    assert read_plant_file("two.mat", (tmp_path / "two.mat").read_bytes()) == words == clean_plant_json(words)
    own = LESSON.fit(words)
    shown = outcome(own, input="step", input2="sine", amplitude2=own.knob("amplitude2").default / 2)
    d, run, form = shown.design, shown.study.run, shown.study.setting.plain
    A, B, C, F = np.array(two["A"]), np.array(two["B"]), np.array(two["C"]), np.hstack([two["F1"], two["F2"]])

    def rate(t: float, s: np.ndarray) -> np.ndarray:
        x, z, u = s[:3], s[3:], np.array([d["amplitude"], d["amplitude2"] * np.sin(d["omega2"] * t)])
        y = C @ x
        return np.concatenate([A @ x + B @ u + F @ np.kron(u, x), form.A @ z + form.Y @ y + form.B @ u + form.U @ np.kron(u, y)])
    at = [100, 400]
    peer = solve_ivp(rate, (0, run.t[-1]), [*run.x[0], 0], "DOP853", run.t[at], rtol=1e-10, atol=1e-12).y.T
    np.testing.assert_allclose(run.x[at], peer[:, :3], rtol=1e-7, atol=1e-8)
    seen = peer[:, :3] @ C.T @ form.G_y.T + peer[:, 3:] @ form.G_z.T
    np.testing.assert_allclose(run.estimates[at, 0, 0], seen[:, 0], rtol=1e-6, atol=1e-7)
    lone = json.loads(read_plant_file("one.json", json.dumps({k: v for k, v in two.items() if k != "F2"}).encode()))
    assert not np.any(lone["F2"]) and lone["F1"] == two["F1"]


def test_every_input_has_the_choice_of_signals_that_the_first_has() -> None:
    """Random values with a seed of their own, and a hand's; what drives one leaves the other alone."""
    two = {key: SMALL[key] for key in "AC"} | {"B": [[1, 0], [0, 1], [1, 1]], "K": [[0, 0, 1]], "F1": SMALL["F"],
                                               "F2": [[0, 0.2, 0], [0, 0, 0.1], [0.3, 0, 0]]}
    own = LESSON.fit(clean_plant_json(json.dumps(two)))
    assert own.knob("input").options == own.knob("input2").options
    assert {"amplitude2", "omega2", "seed2"} <= set(own.aside)
    most, t_end = own.knob("amplitude2").high, own.knob("kick").high
    u = {kind: outcome(own, input2=kind, hand2=((0.2 * t_end, most / 4), (0.6 * t_end, -most / 2))).study.run.u
         for kind, _ in own.knob("input2").options}
    assert all(np.array_equal(one[:, 0], u["none"][:, 0]) for one in u.values()) and not u["none"][:, 1].any()
    assert [float(u["hand"][round(400 * share), 1]) for share in (0.1, 0.4, 0.9)] == pytest.approx([0, most / 4, -most / 2])
    held = np.unique(u["random"][:-1, 1])
    assert len(held) == 20 and np.abs(held).max() <= own.knob("amplitude2").default
    assert not np.array_equal(outcome(own, input2="random", seed2=7).study.run.u[:, 1], u["random"][:, 1])
    assert not np.array_equal(outcome(own, input="random").study.run.u[:, 0], u["random"][:, 1])
