"""Coulomb friction of the showdown: its law at every sample, a closed form, and the numbers that the step states."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observer_lab.engine import Plant
from observer_lab.engine.sampled import sampled_controller, sampled_loop
from observer_lab.lessons.showdown.controllers import ORDER, OWN_PAIR, players
from observer_lab.lessons.showdown.friction import Guides, guides, isolation, noise, rub, rubbed
from observer_lab.lessons.showdown.lesson import LESSON
from observer_lab.lessons.showdown.simulation import RUN_SAMPLES, loop_of, shake, world_of
from observer_lab.plants.platform import model

QUIET = LESSON.apply(LESSON.start(), {"ground": "shaped", "sensor": 1e-14, "v": 1e-14})
PLAYERS = players(1e-14, OWN_PAIR)


def test_an_oscillator_loses_four_times_F_over_k_of_its_swing_in_each_period() -> None:
    """m x″ + k x = −F sign x′: the swing falls in a straight line and ends where |k x| ≤ F; three of them, from three starts."""
    m, k, F, dt, eye = 2.0, 50.0, 0.4, 1e-3, np.eye(3)
    plant = Plant(np.block([[0 * eye, eye], [-k / m * eye, 0 * eye]]), np.vstack([0 * eye, eye / m]), np.hstack([eye, 0 * eye]))
    nobody = sampled_controller(Plant(np.zeros((0, 0)), np.zeros((0, 3)), np.zeros((3, 0)), np.zeros((3, 3)), dt), dt)
    loop = sampled_loop(plant, nobody, range(3), disturbances=plant.B)
    count, starts = round(8 / dt), np.array([0.1, 0.07, 0.05])
    w, f = rub(loop, Guides(np.hstack([0 * eye, eye]), loop.Gamma), F, np.append(starts, np.zeros(3)), np.zeros((count, 6)),
               np.zeros((count, 3)))
    period = round(2 * np.pi * np.sqrt(m / k) / dt)
    for n in (1, 2):
        np.testing.assert_allclose(w[n * period - 200:n * period + 200, :3].max(axis=0)[0], starts[0] - n * 4 * F / k, atol=2e-4)
    np.testing.assert_allclose(w[period - 200:period + 200, 1].max(), starts[1] - 4 * F / k, atol=2e-4)
    assert np.all(np.abs(k * w[-1, :3]) <= F * (1 + 1e-6)) and np.abs(w[-1, 3:]).max() < 1e-9
    np.testing.assert_allclose(f[-1], k * w[-1, :3], atol=1e-6)  # at rest a guide carries the spring


@pytest.mark.parametrize("changes", [{"friction": 1.0}, {"friction": 5.0, "play": "siso", "driver": "second", "delay": 0.4},
                                     {"friction": 3.0, "limited": True, "limit": 2e-3, "drift": 0.5}, {"friction": 20.0, "play": "open"}])
def test_at_every_sample_a_guide_sticks_or_opposes_with_all_it_has(changes: dict[str, object]) -> None:
    d = LESSON.apply(QUIET, changes)
    world, player, most = world_of(d), PLAYERS[ORDER.index(d["play"])], 1e-3 * d["friction"]
    loop, at = loop_of(world, player), guides(world, player)
    w, f = rub(loop, at, most, np.zeros(loop.n), *noise(loop, 1500, 3))
    sliding = w @ at.rows.T
    assert len(w) == 1500 and np.abs(f).max() <= most
    stuck = np.abs(f) < most * (1 - 1e-9)
    assert np.abs(sliding[stuck]).max(initial=0.0) < 1e-12 and stuck.any() and (d["play"] == "open" or not stuck.all())
    assert np.all(f[~stuck] * sliding[~stuck] <= 1e-15)


def test_without_friction_the_run_is_that_of_the_engine() -> None:
    for changes in ({}, {"delay": 1.3, "drift": 0.5, "play": "siso"}, {"limited": True, "limit": 2e-3, "test": "step"}):
        d = LESSON.apply(QUIET, changes)
        who = world_of(d), PLAYERS[ORDER.index(d["play"])], 5, d["test"] == "step", 0.7
        for ours, theirs in zip(rubbed(*who, 0.0), shake(*who), strict=True):
            np.testing.assert_allclose(ours, theirs, atol=1e-9 * np.abs(theirs).max())


@pytest.mark.slow
def test_a_deck_that_sticks_moves_as_the_ground_does_and_the_step_says_by_how_much() -> None:
    """Of one seed no two digits could be said: which lie between 0.17 and 0.41 for the SISO loops. The step says the medians of sixty,
    near which these three lie."""
    world = world_of(QUIET)
    said = {"open": (8.5, 2.0), "siso": (0.23, 0.81), "lqe": (0.20, 0.28)}
    found = {name: np.median([isolation(world, PLAYERS[ORDER.index(name)], seed, 5e-3) for seed in (36, 7, 53)], axis=0) for name in said}
    for name, two in said.items():
        np.testing.assert_allclose(found[name][:2, 0], two, rtol=0.25, err_msg=name)
    assert found["open"][2].min() > 0.999 and found["siso"][2].max() < 1
    p = model.Parameters()
    assert p.m * 9.81 / 5e-3 == pytest.approx(20_000, rel=0.2)
    loop, at = loop_of(world, PLAYERS[0]), guides(world, PLAYERS[0])
    w, _ = rub(loop, at, 1.0, np.zeros(loop.n), *noise(loop, 800, 1))
    ground = w[:, loop.x.stop:loop.x.stop + 4] @ np.array([-2 * np.pi * 0.03, 1.0, 0.0, 0.0])
    np.testing.assert_allclose(w[:, loop.x.start + 6], ground, atol=1e-12)  # vz of the centre is that of the ground


def test_the_stage_and_the_table_know_friction_and_white_ground_has_none() -> None:
    smooth, rough = (LESSON.compute(LESSON.apply(QUIET, {"friction": f})) for f in (0.0, 5.0))
    assert np.abs(smooth.study.run[1] - rough.study.run[1]).max() > 1e-7 and len(rough.study.run[0]) == (RUN_SAMPLES + 3) // 4
    assert smooth.metrics == rough.metrics
    white = [LESSON.compute(LESSON.apply(LESSON.start(), {"friction": f})).study.run[1] for f in (0.0, 20.0)]
    np.testing.assert_array_equal(*white)
    fields = np.arange(45.0).reshape(5, 3, 3)
    fields[1] = np.nan
    trials = replace(_trials(), rubbing=fields)
    table: Any = next(f for f in LESSON.figures(replace(rough, study=replace(rough.study, trials=trials))) if f.id == "friction")
    assert table.rows[0][1].replace("\N{NO-BREAK SPACE}", "") == "0·1·2" and table.rows[1][1]("en") == "unstable"


def _trials():
    from observer_lab.lessons.showdown.study import Trials
    return Trials((None,) * 5)
