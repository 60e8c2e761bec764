"""Languages, lessons and tabs: what is kept, and what is kept apart."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import pytest
from fakes import FakeView, Tab, toy

from observer_lab.session.commands.commands import CheckTask, OpenLesson, Predict, Reveal, SetKnobs, SetLanguage, ShowHint, TurnPage, Undo
from observer_lab.session.commands.exams import AnswerExam
from observer_lab.session.session import Session
from observer_lab.session.state.history import MERGE_WINDOW_S


def two() -> Tab:
    return Tab({"first": toy("first"), "second": toy("second")})


def test_the_language_changes_the_words_and_nothing_else() -> None:
    tab = Tab()
    tab.set(gain=2.0)
    tab.do(Predict(1))
    tab.run_for(0.5)
    tab.do(CheckTask("high"))
    before = tab.picture
    tab.view.clear()
    tab.do(SetLanguage("zh"))
    after = tab.picture
    assert [name for name, _ in tab.view.calls if name != "remember"] == ["build", "show", "pose"]
    assert after.state == replace(before.state, language="zh")
    assert after.design == before.design and after.outcome is before.outcome and after.figures is before.figures
    assert tab.view.of("pose") == [before.state.t]
    tab.do(Undo())
    assert tab["gain"] == 1.0
    tab.do(SetLanguage())  # without an argument it toggles
    assert tab.picture.state.language == "en"


@pytest.mark.parametrize("asked", ["fr", 3, None, ""])
def test_a_language_that_the_lab_does_not_speak_toggles(asked: object) -> None:
    tab = Tab()
    tab.do(SetLanguage(asked))
    assert tab.picture.state.language == "zh"


def test_every_lesson_keeps_its_own_desk() -> None:
    tab = two()
    tab.set(gain=2.0)
    tab.clock.advance(MERGE_WINDOW_S + 0.01)
    tab.set(gain=5.0)
    tab.do(Predict(1))
    tab.do(ShowHint("high"))
    tab.do(CheckTask("high"))
    tab.do(AnswerExam("twice", "2"))
    tab.do(Reveal())
    mine = tab.picture.state
    tab.do(OpenLesson("second"))
    other = tab.picture
    assert other.lesson.id == "second" and other.design == tab.lessons["second"].start()
    assert other.state.predicted is None and not other.state.revealed and not other.state.tasks
    assert not other.state.exams and not other.state.can_undo and not other.state.playing and other.state.t == 0.0
    tab.set(gain=3.0)
    tab.do(OpenLesson("first"))
    back = tab.picture
    assert back.design["gain"] == 5.0
    assert (back.state.predicted, back.state.revealed) == (mine.predicted, mine.revealed)
    assert (back.state.tasks, back.state.exams) == (mine.tasks, mine.exams) and mine.exams
    tab.do(Undo())
    assert tab["gain"] == 2.0
    tab.do(OpenLesson("second"))
    assert tab["gain"] == 3.0


def test_next_and_previous_go_round() -> None:
    tab = two()
    seen = []
    for steps in (+1, +1, -1, -1):
        tab.do(TurnPage(steps))
        seen.append(tab.picture.lesson.id)
    assert seen == ["second", "first", "second", "first"]


def test_a_run_stops_when_another_lesson_opens() -> None:
    tab = two()
    tab.do(Predict(1))
    tab.run_for(0.5)
    tab.do(TurnPage(+1))
    tab.view.clear()
    tab.run_for(1.0)
    assert not tab.view.calls


def test_two_tabs_do_not_mix() -> None:
    lessons = {"first": toy("first"), "second": toy("second")}
    a, b = Tab(lessons), Tab(lessons)
    a.set(gain=2.0)
    a.do(Predict(1))
    a.do(SetLanguage("zh"))
    a.do(CheckTask("high"))
    a.run_for(0.3)
    assert not b.view.calls
    b.session.step(0.0)
    assert b["gain"] == 1.0 and b.picture.state.predicted is None and b.picture.state.language == "en"
    b.do(Undo())
    assert b["gain"] == 1.0
    b.do(OpenLesson("second"))
    assert a.picture.lesson.id == "first" and a["gain"] == 2.0


def test_a_reload_goes_on_where_the_tab_was() -> None:
    tab = two()
    tab.do(OpenLesson("second"))
    tab.set(gain=2.123456789012345, mode="b", poles=[(-0.123456789, 0.987654321), (-0.123456789, -0.987654321)])
    tab.do(Predict(2))
    tab.do(SetLanguage("zh"))
    tab.rest()
    again = Session(tab.lessons, FakeView(), "first")
    again.restore(tab.view.kept)
    again.open()
    assert again.picture is not None
    assert again.picture.design == tab.picture.design
    assert again.picture.state.language == "zh" and again.picture.state.predicted == 2


def test_a_session_works_on_its_own_thread_and_ends_when_closed() -> None:
    view = FakeView()
    session = Session({"toy": toy()}, view, "toy")
    before = set(threading.enumerate())
    session.start()
    session.post(SetKnobs({"gain": 2.0}))
    session.post(OpenLesson("nowhere"))
    session.post(SetKnobs({"gain": 3.0}))
    _until(lambda: session.picture is not None and session.picture.design["gain"] == 3.0)
    _until(lambda: view.calls and session.picture.resting)
    session.close()
    _until(lambda: set(threading.enumerate()) <= before)
    count = len(view.calls)
    session.post(SetKnobs({"gain": 4.0}))
    time.sleep(0.05)
    assert len(view.calls) == count


def test_a_screen_that_breaks_once_does_not_end_the_thread() -> None:
    class Fragile(FakeView):
        broken = False

        def pose(self, t: float) -> None:
            if self.broken:
                self.broken = False
                raise RuntimeError("no pose")
            super().pose(t)
    view = Fragile()
    session = Session({"toy": toy()}, view, "toy")
    session.start()
    try:
        session.post(Predict(1))
        _until(lambda: len(view.of("pose")) > 3)
        view.broken = True
        _until(lambda: not view.broken)
        session.post(SetKnobs({"gain": 3.0}))
        _until(lambda: session.picture is not None and session.picture.design["gain"] == 3.0)
    finally:
        session.close()


def _until(condition: object, seconds: float = 5.0) -> None:
    end = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < end, "it never happened"
        time.sleep(0.01)
