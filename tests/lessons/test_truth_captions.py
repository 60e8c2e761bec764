"""Captions and live sentences that must follow the run: zeros, kicks, roles, unstable loops, ties, and "none" as a contestant."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from observer_lab.course.lesson import Outcome
from observer_lab.engine.simulation import Run
from observer_lab.lessons import LESSONS
from observer_lab.lessons.arm.knobs import EXACT_ENCODER
from observer_lab.lessons.showdown.controllers import SHORT_NAMES
from observer_lab.lessons.showdown.suppression import best_words


def run_of(outcome: Outcome[Any]) -> Run:
    assert outcome.run is not None
    return outcome.run


def shown(lesson: str, **moves: Any) -> Outcome[Any]:
    return LESSONS[lesson].compute(LESSONS[lesson].apply(LESSONS[lesson].start(), moves))


def caption(lesson: str, figure: str, **moves: Any) -> str:
    outcome = shown(lesson, **moves)
    return next(f for f in LESSONS[lesson].figures(outcome) if f.id == figure).caption("en")


def test_an_error_that_is_rounding_is_called_zero() -> None:
    assert np.abs(run_of(shown("error-dynamics", guess_q=1.0)).e).max() < 1e-12
    assert "zero" in caption("error-dynamics", "error", guess_q=1.0) and "settle" not in caption("error-dynamics", "error", guess_q=1.0)


@pytest.mark.parametrize(("kick", "left"), [(-1.0, True), (5.0, False)])
def test_a_kicked_plant_is_not_left_to_itself(kick: float, left: bool) -> None:
    assert ("evolve freely" in shown("error-dynamics", input="none", kick=kick).live("en")) == left


@pytest.mark.parametrize("centre", [0.0, 0.2, -0.2])
def test_a_hidden_mode_is_said_to_be_in_e_where_it_grows_there(centre: float) -> None:
    outcome = shown("hidden-modes", centre=centre)
    size = np.linalg.norm(run_of(outcome).e, axis=1)
    rate = max(p.real for p in outcome.study.unseen)
    follows = np.abs(size[-1]) > 1e-6 * np.exp(rate * run_of(outcome).t[-1]) * size[0]
    assert ("part of e follows" in outcome.live("en")) == bool(follows)


def test_the_last_block_is_named_by_what_it_lacks() -> None:
    assert "the sensor does not see" in caption("hidden-modes", "decomposed")
    assert "the force does not reach" in caption("hidden-modes", "decomposed", plant="unmoved-unstable")


def test_the_crosses_come_from_the_boards_or_from_the_weights() -> None:
    assert "chosen on the boards" in caption("separation", "spectrum")
    assert "that the weights give" in caption("separation", "spectrum", method="weights")


def test_the_best_are_all_that_tie_and_none_where_nothing_helps() -> None:
    gains = np.array([[3.0, -1.0, 2.0], [3.02, -2.0, np.nan], [1.0, -np.inf, 1.0], [3.01, 0.03, 2.1]])
    places = dict(best_words(gains).values)
    assert str(places["short"]) == ", ".join(str(SHORT_NAMES[i]) for i in (1, 2, 4))
    assert str(places["short2"]) == str(SHORT_NAMES[0]) and str(places["short3"]) == str(SHORT_NAMES[4])


@pytest.mark.slow
def test_no_control_wins_where_it_moves_least() -> None:
    outcome = shown("showdown", ground="shaped")
    rms = outcome.study.rms
    said = dict(outcome.live.values) if hasattr(outcome.live, "values") else {}
    for j, place in enumerate(("short", "short2", "short3")):
        if place in said and rms[0, j] < 0.99 * rms[1:, j].min():
            assert str(said[place]) == str(SHORT_NAMES[0])


def test_open_pitch_is_not_called_a_success() -> None:
    said = {closed: next(c for c in shown("decoupling", pitch=closed).checks if c.id == "claim").text("en") for closed in (False, True)}
    assert "not tried" in said[False] and "leaves the loop stable" in said[True]


def test_the_arm_says_which_of_gear_and_encoder_is_not_ideal() -> None:
    encoder: Any = next(k for k in LESSONS["arm"].knobs if k.name == "encoder")
    counting = next(o for o, _ in encoder.options if o != EXACT_ENCODER)
    figures = LESSONS["arm"].figures(shown("arm", gap=0.0, encoder=counting))
    captions = " ".join(f.caption("en") for f in figures)
    assert "whose gear has play" not in captions and "neither" not in captions
