"""Many seeds of a lesson of one's own: P against an independent recursion, verdicts that follow the noise, a class that runs it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from fakes import Tab
from own_lessons import first_files, zipped
from scipy.integrate import solve_ivp
from scipy.linalg import solve_discrete_lyapunov
from scipy.signal import cont2discrete

from observer_lab.classroom.room import ClassRuns
from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Lesson, Outcome
from observer_lab.course.many_seeds import CONSISTENT, OVER_CONFIDENT, UNDER_CONFIDENT, SeedErrors, verdict_words
from observer_lab.course.reading.toml_table import LessonFileError
from observer_lab.lessons import LESSONS
from observer_lab.lessons.from_files.packed import uploaded_lessons
from observer_lab.lessons.from_files.read_lesson import read_lesson
from observer_lab.session.commands.room import RunSeeds

A, B, C = np.array([[0.0, 1.0], [-1.0, -0.5]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])  # of the guide's first lesson
STEP, NOISE, PUSH = 0.03, 0.1, 0.05
RUN = f"noise = {NOISE}\ndisturbance = {PUSH}\n"
OWN_P = f"[observer]\nW = {PUSH}\nV = {NOISE**2 * STEP}\n"


class Desk:
    """A room of three followers that notes which runs it is given."""

    audience = ""

    def __init__(self) -> None:
        self.shown: list[ClassRuns | None] = []

    def draw_seeds(self) -> Mapping[int, int]:
        return {7: 70, 3: 30, 9: 90}

    def show_runs(self, runs: ClassRuns | None) -> None:
        self.shown.append(runs)


def files(run: str = RUN, observer: str = "", more: str = "") -> dict[str, str]:
    """The guide's first lesson with noise in its run."""
    made = first_files("noisy")
    toml = made["lesson.toml"].replace("[run]\n", f"[run]\n{run}")
    return {**made, "lesson.toml": more + (toml.replace('[observer]\npoles = "q"\n', observer) if observer else toml)}


def lesson_of(place: Path, made: Mapping[str, str]) -> Lesson:
    home = place / "noisy"
    home.mkdir(exist_ok=True)
    for name, words in made.items():
        (home / name).write_text(words, encoding="utf-8")
    return read_lesson(home, 1, trusted=True)


def errors_of(lesson: Lesson, count: int, **knobs: object) -> SeedErrors:
    outcome: Outcome = lesson.compute(lesson.apply(lesson.start(), knobs))
    assert lesson.seeds is not None
    return [each for _, each in lesson.seeds(outcome, np.random.SeedSequence(5).generate_state(count)) if each is not None][-1]


def test_p_is_that_of_the_differential_equation_and_of_the_limit(tmp_path: Path) -> None:
    found = errors_of(lesson_of(tmp_path, files()), 5)
    L = lesson_of(tmp_path, files()).compute(lesson_of(tmp_path, files()).start()).gains["L"]
    F = A - L @ C
    Phi, Gamma, *_ = cont2discrete((F, L, C, np.zeros((1, 1))), STEP)
    grown = solve_ivp(lambda t, p: (F @ p.reshape(2, 2) + p.reshape(2, 2) @ F.T + PUSH * B @ B.T).ravel(), (0, STEP), np.zeros(4),
                      rtol=1e-11, atol=1e-15).y[:, -1].reshape(2, 2)
    limit = solve_discrete_lyapunov(Phi, grown + NOISE**2 * Gamma @ Gamma.T)
    np.testing.assert_allclose(found.covariance, limit, rtol=1e-4)  # 12 s after P = 0
    P = np.zeros((2, 2))
    for _ in range(len(np.arange(0.0, found.times[1] + 1e-9, STEP)) - 1):
        P = Phi @ P @ Phi.T + grown + NOISE**2 * Gamma @ Gamma.T
    np.testing.assert_allclose(found.sigmas[1], np.sqrt(P[0, 0]), rtol=1e-6)


@pytest.mark.parametrize("observer, words", [
    ("", CONSISTENT), (OWN_P, CONSISTENT), (OWN_P.replace(f"W = {PUSH}", f"W = {PUSH / 20}"), OVER_CONFIDENT),
    (OWN_P.replace(f"W = {PUSH}", f"W = {PUSH * 20}"), UNDER_CONFIDENT)])
def test_the_verdict_follows_what_the_observer_assumes(tmp_path: Path, observer: str, words: object) -> None:
    found = errors_of(lesson_of(tmp_path, files(observer=observer)), 200)
    assert verdict_words(found) == words and found.count == 200


def test_a_seed_gives_the_same_run_whichever_others_run_beside_it(tmp_path: Path) -> None:
    lesson = lesson_of(tmp_path, files())
    many, few = errors_of(lesson, 12), errors_of(lesson, 5)
    np.testing.assert_array_equal(many.errors[:5], few.errors)
    np.testing.assert_allclose(many.paths[:, 0], 0.0, atol=1e-12)


def test_cloud_names_the_states_that_are_drawn(tmp_path: Path) -> None:
    found = errors_of(lesson_of(tmp_path, files(more='cloud = ["velocity", "position"]\n')), 5)
    np.testing.assert_array_equal(found.rows, [[0.0, 1.0], [1.0, 0.0]])
    assert "velocity [m/s]" in found.names[0]("en")


@pytest.mark.parametrize("run, more, said", [
    ("", 'cloud = ["velocity", "position"]\n', "needs a plant with two states and noise"), (RUN, 'cloud = ["velocity"]\n', "two states"),
    (RUN, 'cloud = ["velocity", "velocity"]\n', "two states"), (RUN, 'cloud = ["a", "b"]\n', "position")])
def test_a_wrong_cloud_is_refused(tmp_path: Path, run: str, more: str, said: str) -> None:
    with pytest.raises(LessonFileError, match=said):
        lesson_of(tmp_path, files(run, more=more))


def test_a_lesson_without_noise_runs_no_seeds(tmp_path: Path) -> None:
    assert lesson_of(tmp_path, files("")).seeds is None
    with pytest.raises(KnobError, match="no noise"):
        errors_of(lesson_of(tmp_path, files("noise = 0.0\ndisturbance = 0.0\n")), 5)


def test_a_class_runs_a_lesson_from_a_zip_and_each_seat_gets_its_own() -> None:
    own = {each.id: each for each in uploaded_lessons("mine.zip", zipped({"noisy": files()}), tuple(LESSONS))}
    desk = Desk()
    tab = Tab(own, "noisy", desk=desk)
    tab.do(RunSeeds())
    for _ in range(8):
        tab.clock.advance(0.25)
        tab.session.step(0.0)
    runs = desk.shown[-1]
    assert runs is not None and set(runs.runs) == {7, 3, 9} and runs.name["zh"] == "position [m]的误差"
    assert tab.picture.many is not None and tab.picture.many.found is not None and tab.picture.many.found.count == 3
