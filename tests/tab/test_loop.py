"""The part of the run in which the error lives: shown when a lesson opens, looped under a hand, silent when it has settled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fakes import MODEL, Tab, same, toy, toy_compute, toy_figures
from hypothesis import given
from hypothesis import strategies as st

from observer_lab.course.error_window import (
    AFTER_SHARE,
    DECAYED_SHARE,
    MIN_REST_SHARE,
    MIN_WINDOW_SHARE,
    MOMENTS,
    apart,
    find_error_window,
    run_end,
)
from observer_lab.course.figures.records import LineFigure
from observer_lab.course.lesson import Design, Outcome, Stage
from observer_lab.session.commands.commands import (
    Kick,
    OpenLesson,
    PageSeen,
    PlaceOpened,
    Play,
    Predict,
    Reveal,
    Rewind,
    Seek,
    SetLanguage,
)
from observer_lab.session.handlers.playback import FRAME_S, HAND_ROUNDS, OPENING_ROUNDS


def with_ghost(design: Design) -> Outcome:
    """The toy's run with an estimate that starts at zero and catches up at the rate 10."""
    outcome = toy_compute(design)
    assert outcome.stage is not None
    t, x = outcome.stage.t, outcome.stage.x
    return replace(outcome, stage=replace(outcome.stage, xhat=x * (1 - np.exp(-10.0 * t))[:, None]))


def opened(predicted: bool = True) -> Tab:
    tab = Tab({"toy": toy(compute=with_ghost), "other": toy("other", compute=with_ghost)})
    if predicted:
        tab.do(Predict(1))
        tab.run_for(2.2)
    tab.view.clear()
    return tab


def rounds(tab: Tab, patience: float = 60.0) -> int:
    """How often the loop begins anew before it falls silent."""
    for _ in range(round(patience / FRAME_S)):
        tab.clock.advance(FRAME_S)
        tab.session.step(0.0)
        if not tab.picture.state.moving:
            return int(np.count_nonzero(np.diff(tab.view.of("pose")) < -1e-6))
    raise AssertionError("the loop does not end")


# --- the law -------------------------------------------------------------------------------------------------------
@given(st.floats(0.3, 50.0), st.floats(0.0, 0.7), st.floats(1.0, 100.0), st.floats(1e-3, 1.0))
def test_the_part_holds_the_peak_of_the_error_and_ends_after_its_death(rate: float, share: float, horizon: float, size: float) -> None:
    """An error that a kick wakes at `since` and that dies like e^{−rate t}."""
    t = np.linspace(0.0, horizon, 400)
    since = share * horizon
    e = np.where(t >= since, size * np.exp(-rate * 10 / horizon * (t - since)), 0.0)
    stage = Stage(MODEL.body, t, np.column_stack([e, 0 * t]), np.zeros((400, 2)))
    part = find_error_window(stage, since)
    assert since <= part.begin <= part.peak <= part.telling <= part.end <= horizon and part.telling > part.begin
    assert part.end - part.begin >= min(MIN_WINDOW_SHARE * horizon, horizon - since) * (1 - 1e-9)
    assert part.begin - since <= 2 * horizon / (MOMENTS - 1)
    moments, gap = apart(stage)
    late = moments > part.end + 1e-9
    assert np.all(gap[late] <= DECAYED_SHARE * gap.max())
    dead = since + np.log(1 / DECAYED_SHARE) * horizon / (10 * rate)
    assert (
        part.end
        <= max(dead + 4 * horizon / (MOMENTS - 1), since + MIN_WINDOW_SHARE * horizon) + AFTER_SHARE * (part.end - part.begin) + 1e-9
    )
    assert 2.0 * (1 - 1e-9) <= (part.end - part.begin) / part.rate < 5.0 * (1 + 1e-9)


@pytest.mark.parametrize("gap", [0.0, 1.0], ids=["never apart", "never together"])
def test_where_the_error_is_never_born_or_never_dies_the_part_is_the_run(gap: float) -> None:
    t = np.linspace(0.0, 3.0, 50)
    part = find_error_window(Stage(MODEL.body, t, np.full((50, 2), gap), np.zeros((50, 2))))
    assert (part.begin, part.end) == (0.0, 3.0)


def fallen(design: Design, share: float = 0.1) -> Outcome:
    """The toy's run with a ghost, and both are held from a share of the run on, as after a fall."""
    outcome = with_ghost(design)
    stage = outcome.stage
    assert stage is not None and stage.xhat is not None
    at = np.minimum(np.arange(len(stage.t)), round(share * (len(stage.t) - 1)))
    return replace(outcome, stage=replace(stage, x=stage.x[at], xhat=stage.xhat[at]))


@given(st.floats(0.05, 0.9))
def test_a_run_is_over_shortly_after_a_fall(share: float) -> None:
    stage = fallen(toy().start(), share).stage
    assert stage is not None
    horizon = float(stage.t[-1])
    fall = float(stage.t[round(share * (len(stage.t) - 1))])
    assert fall <= run_end(stage) <= min(horizon, fall + max(AFTER_SHARE * fall, MIN_REST_SHARE * horizon)) + 1e-9
    assert find_error_window(stage).end <= run_end(stage)


def test_what_is_played_ends_after_a_fall_and_a_hand_sees_the_fall_again() -> None:
    tab = Tab({"toy": toy(compute=fallen)})
    tab.do(Predict(1))
    end = run_end(fallen(tab.picture.design).stage)  # type: ignore[arg-type]
    assert end < 0.3 * tab.picture.horizon
    tab.run_for(end + 0.2)
    assert not tab.picture.state.moving and tab.picture.state.t == pytest.approx(end) and tab.picture.state.revealed
    tab.do(Play())
    assert tab.picture.state.playing and tab.picture.state.t < end


# --- the opening ---------------------------------------------------------------------------------------------------
def test_a_lesson_that_is_seen_shows_its_run_a_few_rounds_long_before_any_prediction() -> None:
    tab = opened(predicted=False)
    tab.do(PageSeen(1))
    assert tab.picture.state.moving and rounds(tab) == OPENING_ROUNDS
    state, part = tab.picture.state, find_error_window(with_ghost(tab.picture.design).stage)  # type: ignore[arg-type]
    assert state.t == part.telling and not state.revealed and state.predicted is None
    tab.view.clear()
    tab.run_for(5.0)
    assert not tab.view.calls, "silent when it rests"


def test_a_page_that_is_hidden_stands_still() -> None:
    tab = opened(predicted=False)
    tab.do(PageSeen(1))
    tab.run_for(0.5)
    tab.do(PageSeen(0))
    tab.view.clear()
    tab.run_for(5.0)
    assert not tab.view.calls


def test_where_the_browser_asks_for_calm_a_moved_knob_moves_nothing_else() -> None:
    tab = opened()
    tab.do(PageSeen(0))
    tab.view.clear()
    tab.set(gain=2.0)
    tab.run_for(5.0)
    assert not tab.picture.state.moving and set(tab.view.of("pose")) <= {tab.picture.state.t}
    tab.do(PageSeen(1))
    tab.set(gain=2.5)
    assert tab.picture.state.moving


@pytest.mark.parametrize("seen", [float("nan"), "yes", None])
def test_nonsense_about_being_seen_costs_one_sentence(seen: object) -> None:
    tab = opened(predicted=False)
    tab.do(PageSeen(seen))
    assert not tab.picture.state.moving and len(tab.view.scolded()) == 1


def test_another_lesson_or_language_stops_the_opening() -> None:
    tab = opened(predicted=False)
    tab.do(PageSeen(1))
    tab.do(OpenLesson("other"))
    assert not tab.picture.state.moving and tab.picture.state.t == 0.0
    tab.do(PageSeen(1))
    tab.do(SetLanguage("zh"))
    assert tab.picture.state.moving, "a language is no other run"


# --- the hand ------------------------------------------------------------------------------------------------------
def test_a_knob_plays_the_living_part_and_settles_after_the_last_move() -> None:
    tab = opened()
    tab.set(gain=2.0)
    state = tab.picture.state
    assert state.loop is not None and state.t == state.loop.part.begin
    tab.view.clear()
    for gain in np.linspace(2.0, 4.0, 40):
        tab.set(gain=float(gain))
        tab.run_for(0.1)
    assert tab.picture.state.moving, "as long as the hand moves"
    assert max(tab.view.of("pose")) <= state.loop.part.end + 1e-9
    tab.set(gain=3.0)
    tab.view.clear()
    assert rounds(tab) == HAND_ROUNDS - 1
    assert tab.picture.state.t == pytest.approx(state.loop.part.end, abs=0.1)
    tab.rest()
    tab.view.clear()
    tab.run_for(5.0)
    assert not tab.view.calls


def test_nothing_loops_before_the_prediction() -> None:
    tab = opened(predicted=False)
    tab.set(gain=2.0)
    assert not tab.picture.state.moving


def test_a_run_without_a_ghost_stays_where_it_is() -> None:
    tab = Tab()
    tab.do(Predict(1))
    tab.run_for(2.2)
    tab.set(gain=2.0)
    assert not tab.picture.state.moving and tab.picture.state.t == 2.0


@pytest.mark.parametrize("stop", [[Seek(0.3)], [Play(), Play()]], ids=["sought", "paused"])
def test_a_moment_that_the_person_chose_stays_under_the_hand(stop: list) -> None:
    tab = opened()
    for command in stop:
        tab.do(command)
        tab.run_for(0.3)
    t = tab.picture.state.t
    tab.set(gain=2.0)
    tab.run_for(1.0)
    assert tab.picture.state.t == t and not tab.picture.state.moving


def test_a_hand_in_the_evidence_takes_its_run_over_and_the_answer_follows() -> None:
    tab = Tab({"toy": toy(compute=with_ghost)})
    tab.do(Predict(1))
    tab.run_for(0.1)
    tab.set(gain=2.0)
    state = tab.picture.state
    assert state.loop is not None and not state.playing and state.t == pytest.approx(0.1)
    rounds(tab)
    assert tab.picture.state.revealed


@pytest.mark.parametrize("command, moving", [(Play(), False), (Rewind(), False), (Seek(1.0), False), (Kick(), True)], ids=repr)
def test_the_transports_commands_end_the_loop(command: object, moving: bool) -> None:
    tab = opened()
    tab.set(gain=2.0)
    tab.do(command)  # type: ignore[arg-type]
    assert tab.picture.state.loop is None and tab.picture.state.moving is moving


def test_after_a_kick_the_part_is_the_kicks() -> None:
    t = np.linspace(0.0, 10.0, 400)
    e = np.exp(-3 * t) + np.where(t >= 5.0, 0.5 * np.exp(-3 * (t - 5.0)), 0.0)
    stage = Stage(MODEL.body, t, np.column_stack([e, 0 * t]), np.zeros((400, 2)))
    assert find_error_window(stage).begin == 0.0 and find_error_window(stage).end < 5.0
    assert find_error_window(stage, 5.0).begin == pytest.approx(5.0) and find_error_window(stage, 5.0).end > 6.0


# --- the figure that answers -----------------------------------------------------------------------------------------
def test_the_figure_that_answers_opens_once_when_the_answer_comes() -> None:
    tab = Tab({"toy": toy(compute=with_ghost, answering="x")})
    tab.do(Predict(1))
    assert not tab.view.of("figure")
    tab.run_for(2.2)
    assert tab.view.of("figure") == ["x"]
    tab.do(Play())
    tab.run_for(2.2)
    tab.do(Reveal())
    assert tab.view.of("figure") == ["x"], "who has gone on to another figure is not called back"


def test_who_turns_to_another_figure_while_the_evidence_plays_is_not_called_back() -> None:
    def two_tabs(outcome: Outcome) -> tuple[LineFigure, ...]:
        first, = toy_figures(outcome)
        return first, replace(first, id="y", tab=same("other"))
    for turned, opens in ((0, ["x"]), (1, [])):
        tab = Tab({"toy": toy(compute=with_ghost, figures=two_tabs, answering="x")})
        tab.do(Predict(1))
        tab.do(PlaceOpened(turned, None))
        tab.run_for(2.2)
        assert tab.picture.state.revealed
        assert tab.view.of("figure") == opens
    tab = Tab({"toy": toy(compute=with_ghost, figures=two_tabs, answering="x")})
    tab.do(Predict(1))
    tab.do(PlaceOpened(1, None))
    tab.do(Reveal())
    assert tab.view.of("figure") == ["x"], "who asks for the answer is shown it"
