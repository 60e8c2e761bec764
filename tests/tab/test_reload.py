"""A reload brings back every lesson's desk, and nothing is written over what was kept before it is known."""

from __future__ import annotations

import itertools
import json
import threading
from collections.abc import Callable
from typing import Any

import pytest
from fakes import BROKEN, Clock, FakeView, Tab, toy

from observer_lab.course.lesson import Lesson
from observer_lab.session.commands.commands import (
    CheckTask,
    LookFrom,
    MemoryRecalled,
    OpenLesson,
    Predict,
    Redo,
    Reveal,
    SetKnobs,
    SetLanguage,
    ShowHint,
    ToggleHelp,
    ToggleLecture,
    Undo,
)
from observer_lab.session.commands.exams import AnswerExam, SetKey, WithholdResults
from observer_lab.session.handlers.reload import LATE_MEMORY, RECALL_TIMEOUT_S
from observer_lab.session.session import Session
from observer_lab.session.state import tab_memory
from observer_lab.session.state.history import MAX_UNDO_DESIGNS, History
from observer_lab.session.state.view import ExamAnswer


def three() -> dict[str, Lesson]:
    return {name: toy(name) for name in ("first", "second", "third")}


def worked() -> Tab:
    """A tab in which something was done in two of three lessons; the second is open."""
    tab = Tab(three())
    tab.set(gain=6.0)
    tab.rest()
    tab.do(Predict(1))
    tab.do(Reveal())
    tab.do(ShowHint("low"))
    tab.do(CheckTask("high"))
    tab.do(SetKey("me"))
    tab.do(WithholdResults(True))
    tab.do(AnswerExam("twice", "2"))
    tab.do(OpenLesson("second"))
    tab.set(gain=2.123456789012345, mode="b", poles=[(-0.123456789, 0.987654321), (-0.123456789, -0.987654321)])
    tab.do(SetLanguage("zh"))
    tab.do(ToggleLecture())
    tab.rest()
    return tab


class Again(Tab):
    """A tab after a reload, whose browser has not answered yet; opened without the answer."""

    def __init__(self, lessons: dict[str, Lesson], kept: str | None) -> None:
        self.lessons, self.view, self.clock = lessons, FakeView(kept, answers=False), Clock()
        self.session = Session(lessons, self.view, "first", clock=self.clock)
        self.session.open()
        self.view.clear()

    def answer(self) -> None:
        """The answer comes at last."""
        self.do(MemoryRecalled(self.kept))

    @property
    def kept(self) -> str | None:
        return self.view.kept


def test_a_reload_brings_back_every_lesson_that_was_worked_on() -> None:
    before = worked()
    again = Session(before.lessons, FakeView(), "first")
    again.restore(before.view.kept)
    again.open()
    picture = again.picture
    assert picture is not None and picture.lesson.id == "second"
    assert picture.design == before.picture.design
    assert picture.state.language == "zh" and picture.state.lecture
    again.post(OpenLesson("first"))
    again.step()
    first = again.picture
    assert first is not None and first.design["gain"] == 6.0
    assert first.state.predicted == 1 and first.state.revealed
    assert first.state.tasks["low"].hints == 1 and first.state.tasks["low"].verdict is None
    verdict = first.state.tasks["high"].verdict
    assert verdict is not None and verdict.solved
    assert first.state.exams["twice"].answers == (ExamAnswer("me", 0, "2"),) and first.state.key == "me" and first.state.withheld
    assert first.state.fresh == before.picture.state.fresh != ""


def test_a_lesson_that_is_left_before_its_knobs_rest_is_kept_as_it_was_left() -> None:
    tab = Tab(three())
    tab.set(gain=6.0)
    tab.do(OpenLesson("second"))
    assert tab.view.kept is not None and json.loads(tab.view.kept)["desks"]["first"]["knobs"]["gain"].startswith("6")


def test_a_desk_that_nobody_opened_after_a_reload_outlives_the_next_one() -> None:
    kept = worked().view.kept
    for _ in range(3):
        tab = Tab(three())
        tab.view.kept = None
        session = Session(tab.lessons, tab.view, "first", clock=tab.clock)
        session.restore(kept)
        session.open()
        kept = tab.view.kept
        assert kept is not None
    last = Session(three(), FakeView(), "first")
    last.restore(kept)
    last.open()
    last.post(OpenLesson("first"))
    last.step()
    assert last.picture is not None and last.picture.design["gain"] == 6.0


def test_nothing_is_written_before_the_answer_is_here() -> None:
    """Under load the answer came after three seconds, counted as none, and the tab's start was written over the
    work."""
    kept = worked().view.kept
    tab = Again(three(), kept)
    tab.set(gain=4.0)
    tab.rest()
    tab.do(OpenLesson("third"))
    tab.do(Predict(0))
    assert tab.kept == kept


def test_a_question_without_an_answer_is_asked_again_more_and_more_rarely() -> None:
    tab = Again(three(), None)
    seconds = []
    for second in range(1000):
        before = len(tab.view.asked)
        tab.clock.advance(1.0)
        tab.session.step(0.0)
        seconds += [second] * (len(tab.view.asked) - before)
    gaps = [b - a for a, b in itertools.pairwise(seconds)]
    assert len(seconds) >= 10 and gaps[-1] >= 59 and sorted(gaps) == gaps
    tab.answer()
    asked = len(tab.view.asked)
    tab.clock.advance(1000.0)
    tab.session.step(0.0)
    assert len(tab.view.asked) == asked, "an answer ends the asking"


def test_a_late_answer_restores_a_page_on_which_nothing_was_done() -> None:
    before = worked()
    tab = Again(before.lessons, before.view.kept)
    assert tab.picture.lesson.id == "first"
    tab.answer()
    assert tab.picture.lesson.id == "second" and tab.picture.design == before.picture.design
    assert tab.picture.state.language == "zh"
    tab.do(OpenLesson("first"))
    assert tab["gain"] == 6.0


def test_a_late_answer_takes_nothing_away_and_is_not_lost() -> None:
    before = worked()
    tab = Again(before.lessons, before.view.kept)
    tab.set(gain=4.0)
    tab.answer()
    assert tab["gain"] == 4.0 and tab.picture.lesson.id == "first", "what is on the page stays"
    assert LATE_MEMORY in tab.view.sentences()
    assert tab.picture.state.predicted == 1 and tab.picture.state.tasks["low"].hints == 1
    tab.do(Undo())
    assert tab["gain"] == 6.0, "what was kept is one step of undo away"
    tab.do(Redo())
    assert tab["gain"] == 4.0
    tab.do(OpenLesson("second"))
    assert tab.picture.design == before.picture.design
    tab.rest()
    assert tab.kept is not None and set(json.loads(tab.kept)["desks"]) == {"first", "second"}


def test_a_late_answer_after_a_prediction_keeps_the_prediction() -> None:
    before = worked()
    tab = Again(before.lessons, before.view.kept)
    tab.do(Predict(2))
    tab.answer()
    assert tab.picture.state.predicted == 2


@pytest.mark.parametrize("done", [(LookFrom("all"),), (SetKnobs({"gain": 4.0}), OpenLesson("third")),
                                  (SetKnobs({"gain": 99.0}),)])
def test_a_second_answer_changes_nothing(done: tuple[Any, ...]) -> None:
    tab = Again(three(), worked().view.kept)
    for edit in done:
        tab.do(edit)
    tab.answer()
    design, kept = tab.picture.design, tab.kept
    tab.do(MemoryRecalled(None))
    tab.do(MemoryRecalled(worked().view.kept))
    assert tab.picture.design == design and tab.kept == kept


def test_a_browser_that_kept_nothing_is_written_to_from_then_on() -> None:
    tab = Again(three(), None)
    tab.set(gain=4.0)
    tab.rest()
    assert tab.kept is None
    tab.answer()
    assert tab.kept is not None and '"gain": "4' in tab.kept


def test_a_tab_waits_for_a_quick_answer_before_it_opens() -> None:
    """Or every reload would show the opening lesson first."""
    view = FakeView(worked().view.kept)
    session = Session(three(), view, "first")
    session.start()
    try:
        _until(lambda: session.picture is not None)
        assert [p.lesson.id for p in view.of("build")] == ["second"]
    finally:
        session.close()


def test_a_tab_that_leaves_before_the_answer_costs_no_page() -> None:
    view = FakeView(None, answers=False)
    session = Session(three(), view, "first")
    before = set(threading.enumerate())
    session.start()
    _until(lambda: view.asked)
    session.close()
    _until(lambda: set(threading.enumerate()) <= before)
    assert not view.calls


def test_what_a_tab_that_leaves_has_still_asked_for_is_not_done() -> None:
    """400 commands that waited cost 18 s after their tab had left."""
    class Leaves(FakeView):
        def open_help(self) -> None:
            super().open_help()
            session.close()
    view = Leaves()
    session = Session(three(), view, "first")
    session.restore(None)
    session.open()
    view.clear()
    session.post(ToggleHelp())
    for _ in range(400):
        session.post(SetLanguage())
    session.step(0.0)
    assert [name for name, _ in view.calls] == ["help"]


def test_what_is_kept_is_bounded_and_the_latest_work_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    most = 3000
    monkeypatch.setattr(tab_memory, "MAX_MEMORY_BYTES", most)
    tab = Tab({f"lesson{i}": toy(f"lesson{i}") for i in range(40)})
    for i in range(40):
        tab.do(OpenLesson(f"lesson{i}"))
        tab.set(gain=3.123456789)
        tab.rest()
    kept = tab.view.kept
    assert kept is not None and most / 2 < len(kept.encode()) <= most
    read = tab_memory.read_memory(kept, tab.lessons)
    assert read is not None and read.lesson == "lesson39"
    count = len(read.lesson_states)
    assert list(read.lesson_states) == [f"lesson{i}" for i in range(39, 39 - count, -1)] and 3 < count < 40


TOY = {"version": 1, "lesson": "toy", "knobs": {"gain": "3"}}
HEAD = {"version": 2, "lesson": "toy", "desks": {}}


@pytest.mark.parametrize("kept", [
    "", "{", "[]", "null", "3", '{"version": 1}', "[" * 50_000, '{"version": 2, "desks":' + "[" * 50_000, "9" * 10_000,
    "x" * 1_000_000, *(json.dumps(data) for data in (
        TOY, {**HEAD, "version": 3}, {**HEAD, "lesson": "nowhere"}, {**HEAD, "lesson": []}, {**HEAD, "desks": [1]},
        {**HEAD, "desks": 3}, {**HEAD, "yours": {"A": 1}}, {**HEAD, "yours": "x"}, {**HEAD, "language": ["en"]},
        *({**HEAD, "desks": {"toy": desk}} for desk in (
            None, 3, [], {}, {**TOY, "knobs": {"gain": "NaN"}}, {**TOY, "knobs": {"gain": 1e999}},
            {**TOY, "knobs": {"nobody": 1}}, {**TOY, "knobs": 3}, {**TOY, "lesson": "nowhere"},
            {**TOY, "plant": {"A": 1}}, {**TOY, "knobs": {"gain": str(BROKEN)}})))),
])
def test_a_torn_memory_of_the_tab_opens_the_lesson_at_its_start(kept: str) -> None:
    """With a design that cannot be computed, reload after reload would end in the same empty page."""
    session = Session({"toy": toy()}, FakeView(), "toy")
    session.restore(kept)
    session.open()
    assert session.picture is not None and session.picture.design == toy().start()


@pytest.mark.parametrize("more", [
    {"predicted": 7}, {"predicted": "1"}, {"predicted": True}, {"tasks": 3}, {"tasks": {"high": 3}},
    {"tasks": {"high": [1, 2]}}, {"tasks": {"high": [-1, False, True]}}, {"tasks": {"high": ["1", False, True]}},
    {"tasks": {"nobody": [1, True, True]}}, {"exams": "yes"}, {"exams": {"nobody": [1, []]}},
    {"exams": {"twice": [0, []]}}, {"exams": {"twice": [1, 2]}}, {"revealed": True},
])
def test_what_was_never_done_is_not_believed(more: dict[str, Any]) -> None:
    session = Session({"toy": toy()}, FakeView(), "toy")
    session.restore(json.dumps({**HEAD, "desks": {"toy": {**TOY, **more}}}))
    session.open()
    assert session.picture is not None and session.picture.design["gain"] == 3.0
    state = session.picture.state
    assert state.predicted is None and not state.revealed and not state.tasks and not state.exams


@pytest.mark.parametrize("walked", [0, 1, 3])
def test_a_design_that_is_slipped_in_is_one_undo_away_and_nothing_else_moves(walked: int) -> None:
    lesson = toy()
    designs = [lesson.apply(lesson.start(), {"gain": float(i)}) for i in range(2, 7)]
    history = History(lesson.start())
    for i, design in enumerate(designs):
        history.push(design, None, float(i))
    for _ in range(walked):
        history.move(-1)
    present, ahead = history.design, history.can_redo
    late = lesson.apply(lesson.start(), {"gain": 9.0})
    assert history.insert_before_present(late) and history.design == present and history.can_redo == ahead
    assert history.move(-1) and history.design == late and history.move(1) and history.design == present
    assert not history.insert_before_present(present)


@pytest.mark.parametrize("walked", [0, 1, 100])
def test_a_full_history_takes_a_design_in_too(walked: int) -> None:
    lesson = toy()
    history = History(lesson.start())
    for i in range(MAX_UNDO_DESIGNS + 5):
        history.push(lesson.apply(lesson.start(), {"gain": 10 * i / (MAX_UNDO_DESIGNS + 5)}), None, float(i))
    for _ in range(walked):
        history.move(-1)
    present, late = history.design, lesson.apply(lesson.start(), {"gain": 9.99999})
    assert history.insert_before_present(late) and history.design == present and history.move(-1) and history.design == late
    assert len(history.save()[0]) == MAX_UNDO_DESIGNS


def _until(condition: Callable[[], Any]) -> None:
    end = threading.Event()
    for _ in range(int(20 * RECALL_TIMEOUT_S / 0.01)):
        if condition():
            return
        end.wait(0.01)
    raise AssertionError("it never happened")
