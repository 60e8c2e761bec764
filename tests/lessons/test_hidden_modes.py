"""Hidden modes: what no gain moves, what the sensor does not show, and what is lost or kept by it."""

from __future__ import annotations

import numpy as np
import pytest
from lesson_checks import by_knobs
from scipy.linalg import expm

from observer_lab.engine import Scenario, simulate
from observer_lab.engine.systems import match_poles
from observer_lab.lessons.hidden_modes.figures import RANDOM_GAINS, random_poles
from observer_lab.lessons.hidden_modes.knobs import COMMON, PLANT_CASES, RELATIVE, UNCONTROLLABLE_CASES, UNOBSERVABLE_CASES
from observer_lab.lessons.hidden_modes.lesson import LESSON
from observer_lab.lessons.hidden_modes.study import movable


def outcome(**changes):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def run_of(**changes):
    run = outcome(**changes).run
    assert run is not None
    return run


def common_roots(wall: float) -> np.ndarray:
    """The roots of s² + 0.5 s + wall: both unit blocks on one wall spring and damper each."""
    return np.roots([1.0, 0.5, wall])


@pytest.mark.parametrize("name, wall", [("unseen-unstable", -0.5), ("unseen-stable", 0.3), ("unmoved-unstable", -0.5),
                                        ("unmoved-stable", 0.3)])
def test_bolts_are_the_common_motion(name, wall):
    case = PLANT_CASES[name]
    bolts = case.unseen or case.unmoved
    assert match_poles(bolts, common_roots(wall))[1] < 1e-12
    assert bool(case.unseen) == (name in UNOBSERVABLE_CASES) and bool(case.unmoved) == (name in UNCONTROLLABLE_CASES)


def test_lights():
    lit = {name: {c.id: c.holds for c in outcome(plant=name).checks} for name in PLANT_CASES}
    names = ("observable", "detectable", "controllable", "stabilizable", "error", "loop")
    table = {name: "".join("X" if lit[name][k] else "." for k in names) for name in lit}
    assert table == {"unseen-unstable": "..XX..", "unseen-stable": ".XXXXX", "unmoved-unstable": "XX..X.",
                     "unmoved-stable": "XX.XXX", "visible": "XXXXXX"}


@pytest.mark.parametrize("seed", range(5))
def test_error_diverges_for_every_gain(seed):
    """The left eigen-relation holds for any L at all: (A − LC) v = 0.5 v with v the common motion."""
    p = PLANT_CASES["unseen-unstable"].model.plant
    L = np.random.default_rng(seed).normal(size=(4, 1)) * 10.0 ** seed
    v = np.array([1.0, 1.0, 0.5, 0.5])
    np.testing.assert_allclose((p.A - L @ p.C) @ v, 0.5 * v, atol=1e-12)
    run = simulate(Scenario(p, L=np.random.default_rng(seed).normal(size=(4, 1)), x0=0.1 * v, horizon=6.0, dt=0.05))
    np.testing.assert_allclose(run.e, 0.1 * np.exp(0.5 * run.t)[:, None] * v, rtol=1e-8)
    np.testing.assert_allclose(run.y, 0.0, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_state_diverges_for_every_feedback_by_duality(seed):
    p = PLANT_CASES["unmoved-unstable"].model.plant
    K = np.random.default_rng(seed).normal(size=(1, 4)) * 10.0 ** seed
    v = np.array([0.5 + 0.5, 0.5 + 0.5, 1.0, 1.0])  # left eigenvector (s + c, s + c, 1, 1) at s = 0.5, c = 0.5
    np.testing.assert_allclose(v @ (p.A - p.B @ K), 0.5 * v, atol=1e-12)
    twin = p.dual()
    assert match_poles(np.linalg.eigvals(p.A - p.B @ K), np.linalg.eigvals(twin.A - K.T @ twin.C))[1] < 1e-4 * 10.0 ** seed


def test_random_gains_never_pass_the_bolt():
    def rightmost(name: str, observer: bool) -> np.ndarray:
        poles = random_poles(PLANT_CASES[name], 1, observer)
        assert poles.shape == (RANDOM_GAINS, 4)
        return np.max(np.real(poles), axis=1)
    for name, bolt in (("unseen-unstable", 0.5), ("unseen-stable", -0.25)):
        assert np.min(rightmost(name, True)) > bolt - 1e-9
    for name, bolt in (("unmoved-unstable", 0.5), ("unmoved-stable", -0.25)):
        assert np.min(rightmost(name, False)) > bolt - 1e-9
    assert np.min(rightmost("unseen-unstable", False)) < 0.0  # where nothing is bolted, some of the same draws settle


def test_hidden_unstable_departs_while_the_trace_stays_flat():
    run = run_of()
    late = run.t > 7.0
    assert np.max(np.abs(run.y[late])) < 1e-3 * np.max(np.abs(run.y))
    assert np.min(np.abs(run.x[late, 0])) > 1.0
    assert np.min(np.linalg.norm(run.e[late] @ COMMON.T, axis=1)) > 1.0
    assert np.max(np.linalg.norm(run.e[late] @ RELATIVE.T, axis=1)) < 1e-6


def test_hidden_stable_is_slow_but_fine_and_poles_do_not_hurry_it():
    p = PLANT_CASES["unseen-stable"].model.plant
    start = np.array([0.06, 0.06, 0, 0])
    for poles in ((-3.5 - 4j, -3.5 + 4j), (-8, -7)):
        run = run_of(plant="unseen-stable", observer_part=poles)
        natural = np.array([expm(p.A * t) @ start for t in run.t[::50]])
        np.testing.assert_allclose(run.e[::50] @ COMMON.T, natural @ COMMON.T, atol=1e-10)
        assert np.linalg.norm(run.e[-1]) < 0.2 * np.linalg.norm(run.e[0])


@pytest.mark.parametrize("name", PLANT_CASES)
def test_movable_poles_move_and_bolts_stay(name):
    case = PLANT_CASES[name]
    left, right = movable(case)
    wanted = {left: (-1.7, -2.2, -1.1 - 2j, -1.1 + 2j), right: (-4, -3, -2 - 1j, -2 + 1j)}
    wanted = {knob: poles[:2] if knob.endswith("part") else poles for knob, poles in wanted.items()}
    o = outcome(plant=name, **wanted)
    p = case.model.plant
    assert match_poles((*wanted[left], *case.unmoved), np.linalg.eigvals(p.A - p.B @ o.gains["K"]))[1] < 1e-6
    assert match_poles((*wanted[right], *case.unseen), np.linalg.eigvals(p.A - o.gains["L"] @ p.C))[1] < 1e-6
    boards = {b.id: b for b in o.boards}
    assert boards["controller"].fixed == case.unmoved and boards["observer"].fixed == case.unseen
    assert boards["controller"].knob == left and boards["observer"].knob == right


def test_a_pole_may_be_dragged_onto_a_bolt():
    o = outcome(observer_part=(-1, 0.5))
    assert o.metrics["error_rate"] == pytest.approx(0.5, abs=1e-6)
    o = outcome(plant="unseen-stable", observer_part=PLANT_CASES["unseen-stable"].unseen)
    assert o.metrics["error_rate"] == pytest.approx(-0.25, abs=1e-6)


@pytest.mark.parametrize("name", PLANT_CASES)
def test_decomposition_keeps_the_zeros_of_kalman(name):
    case = PLANT_CASES[name]
    d, p = case.decomposition, case.model.plant
    np.testing.assert_allclose(d.T @ d.A, p.A @ d.T, atol=1e-12)
    s = case.decomposition.sizes[0]
    if case.unseen:
        assert not np.any(d.A[:s, s:]) and not np.any(d.C[:, s:])
    if case.unmoved:
        assert not np.any(d.A[s:, :s]) and not np.any(d.B[s:])
    assert s == (4 if name == "visible" else 2)


def test_tasks_fail_at_the_start_and_pass_at_their_solution():
    for task in by_knobs(LESSON.tasks):
        assert not task.check(outcome()).solved, task.id
        assert task.check(outcome(**task.solution)).solved, task.id


def test_a_kick_wakes_the_sleeping_motion():
    silence = next(task for task in LESSON.tasks if task.id == "silence")
    assert not silence.check(outcome(**silence.solution, kick=1.0)).solved


def test_pbh_distance_is_one_quantity() -> None:
    """Table and formula print the same σ_min."""
    for plant in PLANT_CASES:
        o = LESSON.compute(LESSON.apply(LESSON.start(), {"plant": plant}))
        modes = PLANT_CASES[plant].seen.modes
        rows = next(f for f in LESSON.figures(o) if f.id == "margins").rows
        shown = [m for m in modes if m.pole.imag >= -1e-9]
        for row, mode in zip(rows, shown, strict=True):
            stacked = np.vstack([PLANT_CASES[plant].model.plant.A - mode.pole * np.eye(4), PLANT_CASES[plant].model.plant.C])
            sigma = float(np.linalg.svd(stacked, compute_uv=False)[-1])
            assert str(row[2]).split()[0] == (f"{sigma:.3g}" if mode.visible else "0")
