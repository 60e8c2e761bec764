"""The ranking with friction and coil limit: beside a smooth friction law stepped by Runge–Kutta, the spectra, and its own words."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sampling import whole
from scipy.interpolate import CubicSpline

from observer_lab.lessons.showdown import race as races
from observer_lab.lessons.showdown.controllers import DT, LQE, ORDER, SISO
from observer_lab.lessons.showdown.friction import guides, noise, rub
from observer_lab.lessons.showdown.job import JOB, shown
from observer_lab.lessons.showdown.lesson import LESSON
from observer_lab.lessons.showdown.race import Raced, leaders, places, race
from observer_lab.lessons.showdown.simulation import ground_filter, loop_of, plant_of
from observer_lab.lessons.showdown.study import Trials
from observer_lab.text import languages

SHAPED = LESSON.apply(LESSON.start(), {"ground": "shaped"})
SMOOTH_M_S, SUBSTEPS = 3e-8, 30  # the friction law F tanh(sliding / SMOOTH); steps of a sample


def raced(**changes: object) -> tuple[Any, Raced]:
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), changes))
    *_, (share, found) = race(outcome.study.world, outcome.study.five, int(outcome.design["seed"]), 1e-3 * outcome.design["friction"])
    assert share == 1.0 and found is not None
    return outcome, found


@pytest.mark.parametrize("who", [LQE, SISO])
def test_a_run_with_friction_and_limit_is_that_of_a_smooth_law_stepped_by_runge_kutta(who: str) -> None:
    """ẋ = A x + B u + G d + M⁻¹ Jᵀ f with f = −F tanh(J q̇ − ġ)/ε, u held over a sample and clipped; the ground as a cubic spline."""
    limit, F, count = 0.02, 5e-3, 1500
    m = LESSON.compute(LESSON.apply(SHAPED, {"limited": True, "limit": limit, "friction": 1e3 * F})).study
    player = m.five[ORDER.index(who)]
    loop, plant, p = loop_of(m.world, player), plant_of(m.world.parameters)[0], m.world.parameters
    jumps, v = noise(loop, count, 4)
    w, _ = rub(loop, guides(m.world, player), F, np.zeros(loop.n), jumps, v)
    shape = ground_filter()
    ground = w[:, loop.x.stop:loop.x.stop + shape.n]
    moved, moving = (CubicSpline(DT * np.arange(count), ground @ rows.T) for rows in (shape.C, shape.C @ shape.A))
    J = np.array([[0, 1, -p.a], [0, 1, p.a], [1, 0, p.h]])
    mass = np.linalg.inv(np.diag([p.m, p.m, p.J])) @ J.T
    A, B, C = plant.A, plant.B, plant.C
    step = player.controller.last
    E = player.controller.E[-1]

    def rates(t: float, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        sliding = J @ x[5:8] - moving(t)[[0, 0, 1]]
        out = A @ x + B[:, :3] @ u + B[:, 3:] @ moved(t)
        out[5:8] -= mass @ (F * np.tanh(sliding / SMOOTH_M_S))
        return out

    h, x, c = DT / SUBSTEPS, np.zeros(plant.n), np.zeros(step.n)
    found, clipped = np.zeros((count, plant.n)), 0
    for k in range(count - 1):
        y = C @ x + v[k]
        asked = step.C @ c + step.D @ y
        u = np.clip(asked, -limit, limit)
        clipped += int(np.any(u != asked))
        c = step.A @ c + step.B @ y + E @ u
        for i in range(SUBSTEPS):
            t = DT * k + h * i
            k1 = rates(t, x, u)
            k2 = rates(t + h / 2, x + h / 2 * k1, u)
            k3 = rates(t + h / 2, x + h / 2 * k2, u)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(t + h, x + h * k3, u))
        found[k + 1] = x
    assert clipped > 20
    for j in (5, 6):  # horizontal and vertical velocity of the deck
        ours, theirs = w[:, loop.x][:, j], found[:, j]
        assert np.std(ours - theirs) < 0.15 * np.std(theirs), (who, j)


def test_without_friction_and_limit_the_runs_give_the_predicted_motion() -> None:
    outcome, found = raced(ground="shaped")
    predicted = outcome.study.band_rms(0.5, 3.0)
    np.testing.assert_allclose(found.rms[1:], predicted[1:], rtol=0.25)
    np.testing.assert_allclose(found.rms[0], predicted[0], rtol=0.45)  # its resonances are narrow beside the length of a run
    assert np.all(found.clipped == 0)
    near = np.array([np.interp(found.f, outcome.study.f, s.density[:, 0]) for s in outcome.study.spectra])[1:]
    assert abs(float(np.median(np.log(found.density[1:] / near)))) < 0.3


@pytest.mark.slow
def test_the_scene_says_what_six_runs_give() -> None:
    outcome, found = raced(ground="shaped", sensor=1e-14, v=1e-14, friction=5.0)
    siso, lqe = (ORDER.index(name) for name in (SISO, LQE))
    predicted = outcome.study.band_rms(0.5, 3.0)
    said = LESSON.words["en"].scenes["friction"]
    for value, words in ((predicted[siso, 0], said.text), (predicted[lqe, 0], said.text), (found.rms[siso, 0], said.say),
                         (found.rms[lqe, 0], said.say)):
        assert f"{value:.2f}" in words
    assert found.rms[siso, 1] < found.rms[lqe, 1] and predicted[siso, 1] > predicted[lqe, 1]


@pytest.fixture
def few_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two runs of each controller in the suite, and by `--whole` as many as the page has."""
    if not whole():
        monkeypatch.setattr(races, "RACE_RUNS", 2)


@pytest.mark.slow
def test_a_coil_limit_changes_the_motion_and_the_share_of_clipped_commands_is_stated(few_runs: None) -> None:
    _, free = raced()
    _, bound = raced(limited=True, limit=0.02)
    siso = ORDER.index(SISO)
    assert bound.clipped[siso] > 0.5 > bound.clipped[ORDER.index(LQE)] > 0 and bound.rms[siso, 0] > 1.1 * free.rms[siso, 0]


def test_places_are_shared_within_a_percent_and_a_lost_loop_is_last() -> None:
    assert places(np.array([3.0, 1.0, 1.005, 2.0, np.nan])).tolist() == [4, 1, 1, 3, 5]


def _with(found: Raced | None, **changes: object):  # type: ignore[no-untyped-def]
    outcome = LESSON.compute(LESSON.apply(SHAPED, changes))
    return shown(outcome, replace(Trials((None,) * 5), raced=found))


def test_table_figure_caption_and_live_sentence_follow_the_runs() -> None:
    rms = np.array([[5.0, 1, 1], [1.0, 2, 2], [2.0, 3, 3], [3.0, 4, 4], [np.nan] * 3])
    found = Raced(rms, np.array([0, 0.1, 0, 0, np.nan]), np.array([1.0, 2.0]), np.ones((5, 2)))
    for changes, runs in (({}, None), ({"friction": 5.0}, None), ({"friction": 5.0}, found), ({"limited": True}, found)):
        outcome = _with(runs, **changes)
        drawn: dict[str, Any] = {f.id: f for f in LESSON.figures(outcome)}
        table, line = drawn["race"], drawn["race_spectrum"]
        assert len(table.rows) == 5 and len(line.curves) == (5 if runs is None else 6)
        if runs is None:
            wanted = "Not computed yet" if changes else "the prediction is the ranking"
            assert wanted in table.caption("en") and {row[3] for row in table.rows} == {"–"} and "Predicted" in line.caption("en")
            continue
        gap = "\N{NO-BREAK SPACE}·\N{NO-BREAK SPACE}"
        assert table.rows[1][4] == gap.join("122") and table.rows[0][4] == gap.join("411") and table.rows[4][3]("en") == "unstable"
        assert table.rows[1][5] == "10" and "SISO vertically, none in rotation, none horizontally" in outcome.live("en")
        assert outcome.live("en") == leaders(rms)("en") and leaders(rms)("en") in table.caption("en")
        assert "Predicted without" in drawn["suppression"].caption("en") and leaders(rms)("en") in drawn["suppression"].caption("en")
        assert outcome.metrics["siso_vertical_raced"] == 1.0 and "decoupled_vertical_raced" not in outcome.metrics
        assert all(outcome.live(language) for language in languages())


def test_the_long_comparison_begins_with_the_ranking_where_something_acts(few_runs: None) -> None:
    for changes, wanted in (({"friction": 5.0}, True), ({}, False)):
        outcome = LESSON.compute(LESSON.apply(SHAPED, changes))
        first = next((found for _, found in JOB.outcomes(outcome) if found is not None and found.study.trials is not None and (
            found.study.trials.raced is not None or any(found.study.trials.noise))), None)
        assert first is not None and (first.study.trials.raced is not None) == wanted
