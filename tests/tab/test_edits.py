"""Edits: the latest value of a knob wins, commands are never lost, every step can be undone."""

from __future__ import annotations

import pytest
from fakes import FakeView, Tab, toy, toy_compute

from observer_lab.course.lesson import Design, Outcome
from observer_lab.session.commands.commands import LookFrom, Predict, Redo, Reset, SetKnobs, ToggleHelp, ToggleLecture, Undo
from observer_lab.session.session import FINAL_PICTURE_DELAY_S, Session
from observer_lab.session.state.history import MERGE_WINDOW_S


def counting() -> tuple[list[Design], Tab]:
    seen: list[Design] = []

    def compute(design: Design) -> Outcome:
        seen.append(design)
        return toy_compute(design)
    tab = Tab({"toy": toy(compute=compute)})
    seen.clear()
    return seen, tab


def test_of_many_values_of_a_knob_only_the_latest_is_computed() -> None:
    seen, tab = counting()
    for i in range(50):
        tab.session.post(SetKnobs({"gain": i / 10}))
    tab.session.step(0.0)
    assert [d["gain"] for d in seen] == [4.9]
    assert tab["gain"] == 4.9
    assert len(tab.view.of("show")) == 1


def test_neighbouring_changes_of_different_knobs_all_count() -> None:
    tab = Tab()
    tab.session.post(SetKnobs({"gain": 2.0}))
    tab.session.post(SetKnobs({"offset": 0.5}))
    tab.session.post(SetKnobs({"gain": 3.0}))
    tab.session.step(0.0)
    assert (tab["gain"], tab["offset"]) == (3.0, 0.5)


def test_commands_between_changes_are_neither_dropped_nor_moved() -> None:
    """set 2, set 3, undo, set 4 is not the same as set 4, undo."""
    tab = Tab()
    for edit in (SetKnobs({"gain": 2.0}), SetKnobs({"gain": 3.0}), Undo(), SetKnobs({"offset": 0.5}),
                 LookFrom("all"), LookFrom("plant"), ToggleHelp(), ToggleLecture(), ToggleLecture(), ToggleLecture()):
        tab.session.post(edit)
    tab.session.step(0.0)
    assert (tab["gain"], tab["offset"]) == (1.0, 0.5)
    assert tab.view.of("camera") == ["all", "plant"]
    assert len(tab.view.of("help")) == 1
    assert tab.picture.state.lecture


def test_the_same_value_again_computes_nothing_but_is_echoed() -> None:
    seen, tab = counting()
    tab.set(gain=1.0)
    assert not seen
    assert tab.shown.design["gain"] == 1.0  # a widget that a browser has moved is put back
    assert not tab.picture.state.can_undo


def test_a_moving_knob_shows_drafts_and_one_final_picture_when_it_rests() -> None:
    tab = Tab()
    for value in (2.0, 3.0):
        tab.set(gain=value)
        tab.clock.advance(FINAL_PICTURE_DELAY_S / 2)
        tab.session.step(0.0)
    assert [p.resting for p in tab.view.of("show")] == [False, False]
    tab.rest()
    assert [p.resting for p in tab.view.of("show")] == [False, False, True]
    tab.run_for(1.0)
    assert len(tab.view.of("show")) == 3


def test_undo_and_redo_reach_more_than_two_hundred_steps() -> None:
    tab = Tab()
    values = [round(0.02 * (i + 1), 3) for i in range(250) if round(0.02 * (i + 1), 3) != 1.0]
    for value in values:
        tab.set(gain=value)
        tab.clock.advance(MERGE_WINDOW_S + 0.01)
    back = []
    while tab.picture.state.can_undo:
        tab.do(Undo())
        back.append(tab["gain"])
    assert back == [*reversed(values[:-1]), 1.0]
    assert len(back) >= 200
    forth = []
    while tab.picture.state.can_redo:
        tab.do(Redo())
        forth.append(tab["gain"])
    assert forth == values


def test_undo_with_nothing_left_says_so_and_changes_nothing() -> None:
    tab = Tab()
    before = tab.picture.design
    tab.do(Undo())
    tab.do(Redo())
    assert len(tab.view.sentences()) == 2 and not tab.view.scolded()
    assert tab.picture.design == before


def test_a_new_change_after_undo_forgets_what_could_be_redone() -> None:
    tab = Tab()
    for value in (2.0, 3.0):
        tab.set(gain=value)
        tab.clock.advance(MERGE_WINDOW_S + 0.01)
    tab.do(Undo())
    assert tab["gain"] == 2.0 and tab.picture.state.can_redo
    tab.set(gain=4.0)
    assert not tab.picture.state.can_redo
    tab.do(Undo())
    assert tab["gain"] == 2.0


def test_a_drag_is_one_step_of_undo() -> None:
    tab = Tab()
    tab.set(offset=0.2)
    tab.clock.advance(MERGE_WINDOW_S + 0.01)
    for i in range(20):
        tab.set(gain=2.0 + i / 10)
        tab.clock.advance(0.05)
    tab.do(Undo())
    assert (tab["gain"], tab["offset"]) == (1.0, 0.2)


def test_the_first_drag_of_a_session_can_be_undone_to_the_start() -> None:
    tab = Tab()
    for i in range(20):
        tab.set(gain=2.0 + i / 10)
        tab.clock.advance(0.05)
    tab.do(Undo())
    assert tab.picture.design == tab.lessons["toy"].start()


def test_quick_changes_of_different_knobs_are_different_steps() -> None:
    tab = Tab()
    tab.set(gain=2.0)
    tab.clock.advance(0.05)
    tab.set(offset=0.5)
    tab.do(Undo())
    assert (tab["gain"], tab["offset"]) == (2.0, 0.0)


def test_slow_changes_of_one_knob_are_different_steps() -> None:
    tab = Tab()
    tab.set(gain=2.0)
    tab.clock.advance(MERGE_WINDOW_S + 0.01)
    tab.set(gain=3.0)
    tab.do(Undo())
    assert tab["gain"] == 2.0


def test_a_change_right_after_undo_does_not_swallow_the_design_it_returned_to() -> None:
    tab = Tab()
    tab.set(gain=2.0)
    tab.clock.advance(0.05)
    tab.set(offset=0.5)
    tab.do(Undo())
    tab.set(gain=3.0)
    tab.do(Undo())
    assert (tab["gain"], tab["offset"]) == (2.0, 0.0)


def test_reset_restores_the_start_stops_the_run_and_can_be_undone() -> None:
    tab = Tab()
    tab.set(gain=2.0)
    tab.set(offset=0.5)
    tab.do(Predict(0))
    tab.run_for(0.5)
    tab.do(Reset())
    assert tab.picture.design == tab.lessons["toy"].start()
    assert not tab.picture.state.playing and tab.picture.state.t == 0.0
    assert tab.view.of("pose")[-1] == 0.0
    tab.do(Undo())
    assert (tab["gain"], tab["offset"]) == (2.0, 0.5)


def test_a_design_seen_before_is_not_computed_again() -> None:
    seen, tab = counting()
    tab.set(gain=2.0)
    tab.do(Undo())
    tab.do(Redo())
    assert len(seen) == 1


def test_posting_does_no_work_of_its_own() -> None:
    seen, tab = counting()
    tab.session.post(SetKnobs({"gain": 2.0}))
    tab.session.post(ToggleHelp())
    assert not seen and not tab.view.calls


def test_an_unknown_lesson_is_refused_when_the_session_is_made() -> None:
    with pytest.raises(KeyError, match="There is no lesson nowhere"):
        Session({"toy": toy()}, FakeView(), "nowhere")


def test_a_slow_drag_is_one_step_of_undo_and_the_next_drag_another() -> None:
    """A hand may rest in the middle of a drag for longer than quick changes merge."""
    tab = Tab()
    for gain, grip in ((2.0, 1), (3.0, 1), (4.0, 1), (5.0, 2)):
        tab.session.post(SetKnobs({"gain": gain}, grip))
        tab.session.step(0.0)
        tab.clock.advance(3 * MERGE_WINDOW_S)
    tab.do(Undo())
    assert tab["gain"] == 4.0
    tab.do(Undo())
    assert tab["gain"] == 1.0
