"""The run: locked until a prediction, played by the clock, silent while it stands still."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest
from fakes import Tab, toy, toy_compute

from observer_lab.course.error_window import find_error_window
from observer_lab.course.scenes import Choose, Press, Read
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.commands import (
    ChangeSpeed,
    Command,
    DrawByHand,
    Kick,
    PageSeen,
    Play,
    Predict,
    Reveal,
    Rewind,
    Seek,
    Undo,
)
from observer_lab.session.commands.guide import ChooseOption, GoToScene
from observer_lab.session.handlers.playback import CROWDED, FRAME_S, LATE_POSES_IN_A_ROW, PLAYBACK_SPEEDS, PREDICT_FIRST, REFILL_BEFORE_S
from observer_lab.session.state.history import MERGE_WINDOW_S


def playing(**changes: object) -> Tab:
    tab = Tab({"toy": toy(**changes)})
    tab.do(Predict(1))
    tab.view.clear()
    return tab


@pytest.mark.parametrize("command", [Play(), Seek(1.0), Rewind(), Kick(), Reveal()], ids=repr)
def test_the_run_is_locked_until_a_prediction(command: Command) -> None:
    tab = Tab()
    before = tab.picture.design
    tab.do(command)
    assert tab.view.sentences() == [PREDICT_FIRST]
    state = tab.picture.state
    assert not state.playing and state.t == 0.0 and not state.revealed
    assert tab.picture.design == before
    tab.run_for(0.5)
    assert set(tab.view.of("pose")) <= {0.0}


def test_a_prediction_unlocks_and_starts_the_run() -> None:
    tab = Tab()
    tab.do(Predict(2))
    state = tab.picture.state
    assert state.predicted == 2 and state.playing and not state.revealed


def test_skipping_the_prediction_unlocks_too() -> None:
    tab = Tab()
    tab.do(Predict(-1))
    tab.do(Seek(1.0))
    assert tab.picture.state.t == 1.0


@pytest.mark.parametrize("index", [-2, 3, 99])
def test_there_are_only_so_many_predictions(index: int) -> None:
    tab = Tab()
    tab.do(Predict(index))
    assert tab.picture.state.predicted is None
    assert len(tab.view.scolded()) == 1


def test_poses_follow_the_clock() -> None:
    tab = playing()
    tab.run_for(1.0)
    poses = tab.view.of("pose")
    assert poses == pytest.approx([FRAME_S * (i + 1) for i in range(30)])
    assert not tab.view.of("show")  # a playing run costs poses, not pictures


def test_half_a_frame_moves_nothing() -> None:
    tab = playing()
    tab.clock.advance(FRAME_S / 2)
    tab.session.step(0.0)
    assert not tab.view.of("pose")


@pytest.mark.parametrize("speed", PLAYBACK_SPEEDS)
def test_speed_scales_the_run(speed: float) -> None:
    tab = playing()
    tab.do(ChangeSpeed(-1 if speed < 1 else +1))
    while tab.picture.state.speed != speed:
        tab.do(ChangeSpeed(+1 if speed > 1 else -1))
    tab.run_for(0.3)
    assert tab.view.of("pose")[-1] == pytest.approx(0.3 * speed)


def test_faster_and_slower_stop_at_the_ends_of_the_table() -> None:
    tab = playing()
    for _ in range(10):
        tab.do(ChangeSpeed(+1))
    assert tab.picture.state.speed == PLAYBACK_SPEEDS[-1]
    for _ in range(10):
        tab.do(ChangeSpeed(-1))
    assert tab.picture.state.speed == PLAYBACK_SPEEDS[0]


def test_a_stalled_worker_does_not_leap_over_the_run() -> None:
    tab = playing()
    tab.clock.advance(60.0)
    tab.session.step(0.0)
    assert 0 < tab.view.of("pose")[-1] <= 0.25


def test_the_run_ends_at_its_horizon_reveals_and_falls_silent() -> None:
    tab = playing()
    tab.run_for(2.2)
    state = tab.picture.state
    assert (state.t, state.playing, state.revealed) == (2.0, False, True)
    assert tab.view.of("pose")[-1] == 2.0
    tab.view.clear()
    tab.run_for(1.0)
    assert not tab.view.calls


def test_play_at_the_end_starts_over_and_play_in_the_middle_pauses() -> None:
    tab = playing()
    tab.run_for(2.2)
    tab.do(Play())
    assert tab.picture.state.t == 0.0 and tab.picture.state.playing
    tab.run_for(1.0)
    tab.do(Play())
    assert not tab.picture.state.playing
    assert tab.picture.state.t == pytest.approx(1.0)
    tab.clock.advance(30.0)
    tab.do(Play())  # the pause does not count
    tab.clock.advance(FRAME_S)
    tab.session.step(0.0)
    assert tab.picture.state.playing and tab.view.of("pose")[-1] == pytest.approx(1.0 + FRAME_S)


def test_nothing_is_sent_while_paused_and_idle() -> None:
    tab = playing()
    tab.set(gain=2.0)
    tab.run_for(1.0)
    tab.do(Play())
    tab.rest()
    tab.view.clear()
    for _ in range(100):
        tab.clock.advance(0.1)
        tab.session.step(0.0)
    assert not tab.view.calls


def test_a_tab_that_was_only_opened_sends_nothing() -> None:
    tab = Tab()
    tab.run_for(5.0)
    assert not tab.view.calls


@pytest.mark.parametrize("asked, reached", [(1.0, 1.0), (-5.0, 0.0), (1e9, 2.0), ("1.5", 1.5)])
def test_seek_stays_within_the_run(asked: object, reached: float) -> None:
    tab = playing()
    tab.do(Seek(asked))
    assert tab.picture.state.t == reached and tab.view.of("pose")[-1] == reached


@pytest.mark.parametrize("asked", [float("nan"), float("inf"), "soon", None])
def test_seek_to_no_time_at_all_says_one_sentence(asked: object) -> None:
    tab = playing()
    tab.do(Seek(1.0))
    tab.do(Seek(asked))
    assert tab.picture.state.t == 1.0
    assert len(tab.view.scolded()) == 1


def test_a_kick_is_part_of_the_design_and_can_be_undone() -> None:
    tab = playing()
    tab.run_for(1.0)
    tab.do(Kick())
    assert tab["kick"] == pytest.approx(1.0)
    assert tab.picture.state.playing and tab.picture.state.t == pytest.approx(1.0)
    tab.do(Undo())
    assert tab["kick"] == -1.0


def test_a_kick_after_the_end_strikes_at_the_start() -> None:
    tab = playing()
    tab.run_for(2.2)
    tab.do(Kick())
    assert tab["kick"] == 0.0
    assert tab.picture.state.playing and tab.picture.state.t == 0.0


def test_two_kicks_are_two_steps_of_undo() -> None:
    tab = playing()
    tab.run_for(0.3)
    tab.do(Kick())
    tab.run_for(0.3)
    tab.do(Kick())
    tab.do(Undo())
    assert tab["kick"] == pytest.approx(0.3, abs=1e-6)


def test_a_lesson_without_a_kick_ignores_it() -> None:
    tab = playing(kick=False)
    tab.do(Kick())
    assert tab["kick"] == -1.0 and not tab.view.scolded()


def test_a_hand_track_is_recorded_from_the_present_time_on() -> None:
    tab = playing()
    tab.run_for(0.5)
    tab.do(DrawByHand("hand", 0.4))
    tab.run_for(0.5)
    tab.do(DrawByHand("hand", -0.2))
    times, values = zip(*tab["hand"], strict=True)
    assert times == pytest.approx((0.5, 1.0)) and values == (0.4, -0.2)
    tab.do(Seek(0.2))
    tab.do(DrawByHand("hand", 1.0))
    assert tab["hand"] == ((pytest.approx(0.2), 1.0),)  # drawing anew from 0.2 s replaces what came after


@pytest.mark.parametrize("knob, value", [("gain", 0.5), ("nobody", 0.5), ("hand", 1e9), ("hand", float("nan")),
                                         ("hand", "left"), ("hand", None), ("hand", (0.5,))])
def test_a_bad_hand_costs_one_sentence(knob: str, value: object) -> None:
    tab = playing()
    before = tab.picture.design
    tab.do(DrawByHand(knob, value))
    assert tab.picture.design == before and len(tab.view.scolded()) == 1


def test_time_never_exceeds_a_run_that_has_become_shorter() -> None:
    tab = playing()
    tab.do(Play())
    tab.do(Seek(2.0))
    tab.clock.advance(MERGE_WINDOW_S)
    tab.view.clear()
    tab.set(length=1.0)
    assert max(tab.view.of("pose")) <= 1.0
    assert all(p.state.t <= p.horizon for p in tab.view.of("show"))
    tab.rest()
    assert tab.shown.state.t == 1.0


def test_a_lesson_without_a_run_is_revealed_by_the_prediction() -> None:

    tab = Tab({"toy": toy(compute=lambda d: replace(toy_compute(d), stage=None), figures=lambda o: ())})
    tab.do(Predict(0))
    state = tab.picture.state
    assert state.revealed and not state.playing
    tab.do(Play())
    tab.run_for(0.5)
    assert not tab.picture.state.playing and not tab.view.scolded()


def test_a_view_that_goes_on_by_itself_is_asked_for_little_and_believed() -> None:
    """It is looked after before it has come to its end, and whatever is done meanwhile begins where the run is by then."""
    tab = playing()
    tab.view.plays = 1.0
    tab.run_for(1.2)
    asked = tab.view.of("play")
    assert len(asked) == 2 and not tab.view.of("pose")
    assert [t for t, _, _ in asked] == pytest.approx([FRAME_S, FRAME_S + 1.0 - REFILL_BEFORE_S], abs=1.01 * FRAME_S)
    tab.do(Play())  # a pause, in the middle of what the view has
    assert not tab.picture.state.playing and tab.picture.state.t == pytest.approx(1.2, abs=1e-6)
    assert tab.view.of("pose")[-1] == tab.picture.state.t
    tab.do(Play())
    tab.run_for(1.0)
    assert (tab.picture.state.t, tab.picture.state.playing, tab.view.of("pose")[-1]) == (2.0, False, 2.0)


def test_poses_that_wait_for_other_tabs_again_and_again_are_owned_up_to_once(monkeypatch: pytest.MonkeyPatch) -> None:
    tab, waits = playing(), iter([1.0] * (LATE_POSES_IN_A_ROW - 1) + [0.0] + [1.0] * 20)

    class Crowd:
        @contextmanager
        def turn(self, hand: bool) -> Iterator[float]:
            yield 0.0 if hand else next(waits)
    monkeypatch.setattr("observer_lab.session.session.SCHEDULER", Crowd())
    tab.run_for(LATE_POSES_IN_A_ROW * FRAME_S)
    assert not tab.view.sentences()
    tab.run_for(15 * FRAME_S)
    assert tab.view.sentences() == [CROWDED] and tab.view.of("pose")


RESTING = ("error-dynamics", "separation", "virtual-sensor")


@pytest.mark.parametrize("id", RESTING)
def test_a_scene_begins_where_its_run_shows_most_and_a_question_or_a_press_at_the_start(id: str) -> None:
    tab, seen = Tab({id: LESSONS[id]}, id, mode="guide"), set[bool]()
    for k, scene in enumerate(LESSONS[id].path):
        tab.do(GoToScene(k))
        state, stage = tab.picture.state, tab.picture.outcome.stage
        if stage is None or scene.play or state.performance is not None:
            continue
        asked = isinstance(scene.do, Choose | Press)
        kicked = dict(tab.picture.design.values).get("kick", 0.0)
        resting = 0.0 if asked else find_error_window(stage, kicked).telling
        assert state.t == (resting if scene.moment is None else scene.moment * tab.picture.end), scene.id
        assert not state.moving
        seen.add(asked)
    assert seen == {True, False}


def test_a_run_that_rests_where_the_page_has_put_it_plays_from_its_start_and_where_a_hand_has_from_there() -> None:
    id = "error-dynamics"
    tab = Tab({id: LESSONS[id]}, id, mode="guide")
    tab.do(GoToScene(next(k for k, scene in enumerate(LESSONS[id].path) if isinstance(scene.do, Read) and not scene.play)))
    rests = tab.picture.state.t
    assert rests > 0.0
    tab.do(Play())
    assert (tab.picture.state.t, tab.picture.state.playing) == (0.0, True)
    tab.do(Play())
    tab.do(Seek(rests / 2))
    tab.do(Play())
    assert (tab.picture.state.t, tab.picture.state.playing) == (rests / 2, True)


def test_the_clock_shows_the_moment_at_which_a_calm_answer_rests() -> None:
    id = "record"
    tab = Tab({id: LESSONS[id]}, id, mode="guide")
    tab.do(PageSeen(0.0))
    tab.do(GoToScene(next(k for k, scene in enumerate(LESSONS[id].path) if scene.id == "surprise")))
    tab.do(ChooseOption(0))
    tab.clock.advance(0.2)
    tab.session.step(0.0)
    assert tab.picture.state.t > 0.0 and tab.view.of("pose")[-1] == tab.picture.state.t
