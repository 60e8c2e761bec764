"""Exams in a tab: keys and variants, practice that tells at once, and answers that are noted alone."""

from __future__ import annotations

import json

import pytest
from fakes import FakeView, Tab, toy
from laws import each

from observer_lab.course.exercises.exam import Exam, ExamItem
from observer_lab.course.lesson import Verdict
from observer_lab.session.commands.commands import OpenState, ShowSolution
from observer_lab.session.commands.exams import AnotherVariant, AnswerExam, SetKey, WithholdResults
from observer_lab.session.handlers.exams import SEALED, last_answer, present_item, present_verdict
from observer_lab.session.handlers.tasks import NO_SOLUTIONS
from observer_lab.session.session import Session
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token
from observer_lab.session.state.view import MOST_ANSWERS, TaskState


def exam_of(tab: Tab) -> Exam:
    return tab.picture.lesson.exams[0]


def item(tab: Tab) -> ExamItem:
    return present_item(tab.picture.state, tab.picture.lesson.id, exam_of(tab))


def verdict(tab: Tab) -> Verdict | None:
    return present_verdict(tab.picture.state, tab.picture.lesson.id, exam_of(tab))


def answer(tab: Tab, said: str) -> None:
    tab.do(AnswerExam(exam_of(tab).id, said))


def keyed(key: str) -> Tab:
    tab = Tab()
    tab.do(SetKey(key))
    return tab


def test_a_key_gives_the_same_numbers_everywhere_and_no_key_fresh_ones() -> None:
    numbers = {key: item(keyed(key)) for key in ("Li Wei", " li  wei ", "ＬＩ ｗｅｉ", "Li Wen", "")}
    assert numbers["Li Wei"] == numbers[" li  wei "] == numbers["ＬＩ ｗｅｉ"] != numbers["Li Wen"]
    assert len({item(Tab()).answer for _ in range(5)} | {numbers[""].answer}) > 3
    assert item(keyed("Li Wei")).given == {"a": 2.31}  # on every machine, for ever


def test_another_variant_asks_other_numbers_and_forgets_no_answer() -> None:
    tab = keyed("me")
    answer(tab, "1.5")
    first = item(tab)
    tab.do(AnotherVariant("twice"))
    assert item(tab) != first and last_answer(tab.picture.state, "toy", exam_of(tab)) == "" and verdict(tab) is None
    assert [a.variant for a in tab.picture.state.exams["twice"].answers] == [1]


def test_practice_tells_at_once_and_may_be_tried_again() -> None:
    tab = keyed("me")
    right = item(tab).answer
    for said, solved in ((f"{right + 0.02:.2f}", False), (f"{right:.2f}", True), (f"{right:.2f}".replace(".", ","), True), ("1/3", False)):
        answer(tab, said)
        told = verdict(tab)
        assert told is not None and told.solved is solved and told.text("zh") != told.text("en")
    assert not tab.view.scolded()


def test_an_answer_nearly_right_is_told_so() -> None:
    tab = keyed("me")
    right = item(tab).answer
    for said, words in ((-right, "the sign is not"), (right + 0.02, "digits asked for"), (right + 40, "is not it")):
        answer(tab, f"{said:.2f}")
        told = verdict(tab)
        assert told is not None and not told.solved and words in told.text("en") and told.text("zh") != told.text("en")


def test_withheld_notes_and_tells_nothing_then_or_later() -> None:
    tab = keyed("me")
    practised = item(tab)
    tab.do(WithholdResults(True))
    asked = item(tab)
    answer(tab, f"{asked.answer:.2f}")
    tab.do(AnotherVariant("twice"))  # there is one variant for all
    assert item(tab) == asked != practised and verdict(tab) is None
    assert last_answer(tab.picture.state, "toy", exam_of(tab)) == f"{asked.answer:.2f}"
    assert "olved" not in json.dumps(json.loads(tab.view.kept or "")["desks"]["toy"]["exams"])
    tab.do(WithholdResults(False))
    assert item(tab) == practised and verdict(tab) is None


def test_a_link_brings_withheld_along_and_no_key() -> None:
    tab = keyed("me")
    token = write_token(toy(), SavedState(toy().start(), withheld=True))
    tab.do(OpenState(token))
    assert tab.picture.state.withheld
    assert write_token(toy(), tab.session._show.saved()) == token
    plain = Tab()
    plain.do(OpenState(write_token(toy(), SavedState(toy().start()))))
    assert not plain.picture.state.withheld


@each("said", ["", "  ", "much", "1,234", "4 s", "58 %", "1e999", "1/0", "nan", "inf", "__import__('os')", "1,2,3"])
def test_what_is_no_number_costs_one_sentence_and_is_not_noted(said: str) -> None:
    tab = keyed("me")
    answer(tab, "3")
    answer(tab, said)
    assert len(tab.view.scolded()) == 1 and last_answer(tab.picture.state, "toy", exam_of(tab)) == "3"


@pytest.mark.parametrize("key", [None, 3, "k" * 10_000, "\ud800", "<b>"])
def test_any_key_draws_numbers(key: object) -> None:
    tab = Tab()
    tab.do(SetKey(key))
    assert item(tab).answer > 0 and len(tab.picture.state.key) <= 200


def test_only_so_many_answers_are_kept() -> None:
    tab = keyed("me")
    for _ in range(MOST_ANSWERS + 3):
        answer(tab, "3")
        tab.do(AnotherVariant("twice"))
    assert [a.variant for a in tab.picture.state.exams["twice"].answers] == list(range(4, MOST_ANSWERS + 4))


def test_a_verdict_that_a_browser_made_up_is_not_believed() -> None:
    tab = Tab()
    tab.view = FakeView()
    answers = [["me", 1, "rubbish<b>"], ["me", -1, "3"], [3, 1, "3"], "no", ["me", 1]]
    again = Tab()
    kept = json.dumps({"version": 2, "lesson": "toy", "language": "en", "key": "me", "desks": {"toy": {
        "version": 1, "lesson": "toy", "knobs": {}, "exams": {"twice": [2, answers]}}}})
    again.session._show.recalled = False
    again.session.restore(kept)
    seen = again.picture.state.exams["twice"]
    assert seen.variant == 2 and [a.said for a in seen.answers] == ["rubbish<b>"]
    again.do(AnotherVariant("twice"))
    assert verdict(again) is None


def test_a_sealed_tab_cannot_practise_whatever_is_opened_or_asked() -> None:
    tab = Tab(sealed=True)
    tab.do(SetKey("me"))
    asked = item(tab)
    answer(tab, f"{asked.answer:.2f}")
    tab.do(WithholdResults(False))
    assert tab.view.scolded()[-1] == SEALED and tab.picture.state.withheld and verdict(tab) is None and item(tab) == asked
    open_tab = keyed("me")
    tab.do(OpenState(write_token(open_tab.picture.lesson, SavedState(open_tab.picture.design))))
    assert tab.picture.state.withheld and verdict(tab) is None
    tab.do(ShowSolution("low"))
    assert tab.view.scolded()[-1] == NO_SOLUTIONS and not tab.picture.state.tasks.get("low", TaskState()).solution
    back = Session(tab.lessons, FakeView(), "toy", sealed=True)
    back.restore(open_tab.view.kept)  # a tab that practised elsewhere
    back.open()
    assert back.picture is not None and back.picture.state.withheld and back.picture.state.sealed
