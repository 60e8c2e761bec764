"""A hand pulls the plant: its force is recorded, acts on the plant alone, and comes back bit for bit from a file and a link."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterator

import numpy as np
import pytest
from fakes import Tab
from laws import each
from scipy.linalg import expm

from observer_lab.course.knobs import RELEASE_TIMES, SAMPLE_S, ByHand, Pull
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.commands import Play, Predict, Redo, Seek, SetKnobs, Undo
from observer_lab.session.handlers.playback import PREDICT_FIRST
from observer_lab.session.state.saved_state import SavedState, read_state, write_state
from observer_lab.session.state.token import LONGEST_LINK, read_token, write_token

PULLED = tuple(lesson for lesson in LESSONS.values() if any(isinstance(knob, Pull) for knob in lesson.knobs))
SHARES = (0.2, 0.45, 0.7, 0.5, -0.3)  # of the largest force, one after the other


def grips(lesson: Lesson) -> Iterator[tuple[Pull, np.ndarray]]:
    """The records of a lesson's hand, and how fast the state changes for a force of one."""
    stage = lesson.compute(lesson.start()).stage
    assert stage is not None
    for grip, _ in stage.held:
        knob = lesson.knob(grip.knob)
        assert isinstance(knob, Pull)
        yield knob, np.array(grip.push)


def opened(lesson: Lesson) -> Tab:
    tab = Tab({lesson.id: lesson})
    tab.do(Predict(-1))
    tab.do(Play())
    tab.do(Seek(0.0))
    tab.view.clear()
    return tab


def pull(tab: Tab, name: str, force: float, grip: int = 7, released: bool = False) -> None:
    tab.session.post(SetKnobs({name: ByHand(force, released)}, grip))
    tab.session.step(0.0)


def pulled_by_hand(lesson: Lesson, name: str, most: float) -> Tab:
    """A tab in which a hand has held the plant with some forces and let go."""
    tab = opened(lesson)
    for share in SHARES:
        pull(tab, name, share * most)
        tab.run_for(0.15)
    pull(tab, name, SHARES[-1] * most, released=True)
    tab.rest()
    return tab


def test_five_plants_can_be_pulled() -> None:
    bodies = {str(LESSONS[lesson.id].compute(lesson.start()).stage.body.parts[-1].name) for lesson in PULLED}  # type: ignore[union-attr]
    assert len(bodies) >= 5 and {"separation", "noise", "error-dynamics", "saturation", "arm", "hidden-modes"} <= {x.id for x in PULLED}


@each("lesson", PULLED)
def test_a_hand_that_pulls_is_recorded_and_undone_in_one_step(lesson: Lesson) -> None:
    for knob, push in grips(lesson):
        assert np.any(push)
        tab = pulled_by_hand(lesson, knob.name, knob.most)
        record, picture = tab[knob.name], tab.picture
        *held, let_go, end = record
        assert let_go[1] == pytest.approx(RELEASE_TIMES * SHARES[-1] * knob.most, rel=1e-9) and end[1] == 0.0
        assert end[0] == pytest.approx(let_go[0] + SAMPLE_S)
        assert held and all(abs(force) <= knob.most for _, force in held)
        assert all(math.isclose(t / SAMPLE_S, round(t / SAMPLE_S), abs_tol=1e-9) for t, _ in record)
        assert picture.outcome.stage is not None and record in [found for _, found in picture.outcome.stage.held]
        tab.do(Undo())
        assert tab[knob.name] == ()
        tab.do(Redo())
        assert tab[knob.name] == record
        assert all(np.array_equal(a, b) for a, b in zip(run_of(tab), (picture.outcome.stage.x, picture.outcome.stage.xhat), strict=True))


def run_of(tab: Tab) -> tuple[np.ndarray, ...]:
    stage = tab.picture.outcome.stage
    assert stage is not None and stage.xhat is not None
    return stage.x, stage.xhat


@each("lesson", PULLED)
def test_a_pulled_run_comes_back_bit_for_bit_from_a_file_and_a_link(lesson: Lesson) -> None:
    for knob, _ in grips(lesson):
        picture = pulled_by_hand(lesson, knob.name, knob.most).picture
        saved = SavedState(picture.design, "en")
        first = lesson.compute(picture.design).stage
        for read in (read_state(write_state(lesson, saved), LESSONS), read_token(write_token(lesson, saved), LESSONS)):
            assert read.design == picture.design and not read.notes
            again = lesson.compute(read.design).stage
            assert first is not None and again is not None
            assert np.array_equal(first.x, again.x) and np.array_equal(first.xhat, again.xhat)  # type: ignore[arg-type]


@each("lesson", PULLED)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_link_holds_ten_seconds_of_pulling(lesson: Lesson, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for knob, _ in grips(lesson):
        walk = np.clip(np.cumsum(rng.normal(0.0, 0.15, 200)), -1.0, 1.0) * knob.most
        design = lesson.apply(lesson.start(), {knob.name: [(SAMPLE_S * k, force) for k, force in enumerate(walk)]})
        token = write_token(lesson, SavedState(design, "zh"))
        assert len(token) <= LONGEST_LINK
        assert read_token(token, LESSONS).design == design


def march(A: np.ndarray, start: np.ndarray, push: np.ndarray, forces: np.ndarray, step: float) -> np.ndarray:
    """The states (steps + 1, n) of ẋ = A x with a jump push · SAMPLE_S · force at the grid point nearest to each sample's beginning."""
    jumps = np.zeros((len(forces), len(start)))
    count = round(forces.size * step / SAMPLE_S) + 1
    for k in range(count):
        at = round(SAMPLE_S * k / step)
        if at < len(forces):
            jumps[at] += SAMPLE_S * forces[at] * push
    Phi, states = expm(A * step), [start + jumps[0]]
    for jump in jumps[1:]:
        states.append(Phi @ states[-1] + jump)
    return np.array(states)


def test_the_force_acts_on_the_plant_and_reaches_the_ghost_through_the_sensor_alone() -> None:
    """Beside an expm march of our own of (x, x̂): ẋ = A x, x̂̇ = L C x + (A − L C) x̂, the jumps in x alone."""
    lesson = LESSONS["error-dynamics"]
    (knob, push), = grips(lesson)
    record = ((0.5, 0.6), (0.9, -1.0), (1.3, 0.0))
    outcome = lesson.compute(lesson.apply(lesson.start(), {"input": "none", knob.name: record}))
    run = outcome.run
    assert run is not None
    s = run.scenario
    A, C, L, n = np.asarray(s.plant.A), np.asarray(s.plant.C), np.asarray(s.L), s.plant.n
    wide = np.block([[A, np.zeros((n, n))], [L @ C, A - L @ C]])
    times = np.array([t for t, _ in record])
    sampled = np.round(np.round(run.t / SAMPLE_S), 0) * SAMPLE_S  # the sample that begins nearest to each grid point
    forces = np.array([record[k - 1][1] if (k := int(np.searchsorted(times, t + 1e-9, side="right"))) else 0.0 for t in sampled])
    mine = march(wide, np.concatenate([s.x0, s.xhat0]), np.concatenate([push, np.zeros(n)]), forces, s.dt)
    assert mine == pytest.approx(np.hstack([run.x, run.xhat]), abs=1e-9)
    calm = lesson.compute(lesson.apply(lesson.start(), {"input": "none"})).run
    assert calm is not None
    first = round(0.5 / s.dt) + 1
    assert run.x[:first - 2] == pytest.approx(calm.x[:first - 2], abs=1e-12) and np.abs(run.x - calm.x).max() > 0.1
    assert run.xhat[first - 1] == pytest.approx(calm.xhat[first - 1], abs=1e-12), "no jump of the ghost"


def test_the_run_plays_on_under_a_hand_and_begins_anew_where_it_was_over() -> None:
    tab = opened(LESSONS["separation"])
    assert not tab.picture.state.playing
    pull(tab, "pull", 0.5)
    assert tab.picture.state.playing
    tab.run_for(60.0)
    assert not tab.picture.state.playing
    before = tab["pull"]
    pull(tab, "pull", 0.3, grip=8)
    assert tab.picture.state.playing and tab["pull"] == ((0.0, 0.3),)
    tab.do(Undo())
    assert tab["pull"] == before


def test_the_limit_of_a_hand_is_said_once_each_time_it_takes_hold() -> None:
    tab = opened(LESSONS["separation"])
    knob = tab.lessons["separation"].knob("pull")
    assert isinstance(knob, Pull)
    for force in (0.5, 3.0, 4.0, 5.0):
        pull(tab, "pull", force * knob.most)
        tab.run_for(0.1)
    assert [words("en") for words in tab.view.sentences()] == ["A hand pulls with at most 1.5 N."]
    assert max(force for _, force in tab["pull"]) == knob.most
    pull(tab, "pull", -9.0 * knob.most, grip=8)
    assert len(tab.view.sentences()) == 2


def test_nothing_can_be_pulled_before_a_prediction() -> None:
    tab = Tab({"separation": LESSONS["separation"]})
    pull(tab, "pull", 0.5)
    assert tab.view.sentences() == [PREDICT_FIRST] and tab["pull"] == ()


@pytest.mark.parametrize(("name", "force"), [
    ("pull", math.nan), ("pull", math.inf), ("delay", 1.0), ("observer_poles", 1.0), ("nobody", 1.0)])
def test_a_hand_of_nonsense_costs_one_sentence(name: str, force: float) -> None:
    tab = opened(LESSONS["separation"])
    before = tab.picture.design
    pull(tab, name, force)
    assert tab.picture.design == before and len(tab.view.scolded()) == 1


def test_a_hand_that_never_lets_go_fills_a_record_and_no_more() -> None:
    """However many messages come, a record has one value a sample, and stops with a sentence where it is full."""
    lesson = LESSONS["error-dynamics"]
    tab = opened(lesson)
    for k, share in zip(range(700), itertools.cycle((0.3, -0.4, 0.8)), strict=False):
        pull(tab, "pull", share)
        tab.run_for(1 / 30)
        assert len(tab["pull"]) <= math.floor(tab.picture.state.t / SAMPLE_S + 1e-6) + 1, k
    assert not tab.view.scolded()
    written = json.loads(write_state(lesson, SavedState(tab.picture.design, "en")))
    assert written["knobs"]["pull"]
