"""A tab of a server with a course: what is withheld, what is signed, and what comes back after a reload."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest
from course_makers import DEADLINE, EXAM, SECRET, TASK, right_answer, served, token, toys, word
from fakes import FakeView, Tab

from observer_lab.course.exercises.exam import seed_of
from observer_lab.course.handin.grading import grade
from observer_lab.course.handin.hand_in import read_hand_in
from observer_lab.course.handin.served_course import ServedCourse
from observer_lab.plants.examples import example
from observer_lab.session.commands.commands import OpenState, ShowSolution
from observer_lab.session.commands.exams import AnotherVariant, AnswerExam, HandIn, SaveHandIn, SetKey, SetWord, WithholdResults
from observer_lab.session.handlers.exams import (
    COURSE_DECIDES,
    NEEDS_KEY,
    NOT_IN_COURSE,
    NOT_SOLVED,
    NOTHING_SIGNED,
    OWN_PLANT,
    SIGNED,
    SIGNED_LATE,
    is_withheld,
    last_answer,
    present_item,
    present_variant,
    present_verdict,
)
from observer_lab.session.handlers.tasks import COURSE_NO_SOLUTION
from observer_lab.session.session import Session
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token
from observer_lab.session.state.view import TaskState


def tab_of(lesson: str = "toy", course: ServedCourse | None = None, key: str = "s1") -> Tab:
    course = course or served()
    tab = Tab(toys(), lesson, sealed=True, course=course)
    tab.do(SetKey(key))
    tab.do(SetWord(word(course.course, key)))
    return tab


def exam_of(tab: Tab):
    return tab.picture.lesson.exams[0]


def judged(course: ServedCourse, written: str) -> float:
    return grade(course.course, toys(), [("", written)])[0].points


def test_an_exam_is_drawn_for_the_key_from_the_secret_and_its_right_answer_counts() -> None:
    course = served()
    tab = tab_of(course=course)
    item = present_item(tab.picture.state, "toy", exam_of(tab))
    again, another = (present_item(tab_of(key=key).picture.state, "toy", exam_of(tab)) for key in (" S1", "s2"))
    assert item == again != another
    assert item != exam_of(tab).item(seed_of("s1", "toy", "twice", 0))
    tab.do(HandIn("exam", "twice", f"{item.answer:.2f}"))
    assert tab.view.sentences()[-1] == SIGNED and not tab.view.scolded()
    written = tab.picture.state.hand_ins[EXAM]
    assert judged(course, written) == 5.0 and read_hand_in(course.course, written).student == "s1"
    assert last_answer(tab.picture.state, "toy", exam_of(tab)) == f"{item.answer:.2f}"
    assert present_verdict(tab.picture.state, "toy", exam_of(tab)) is None
    tab.do(SaveHandIn(EXAM))
    assert tab.view.of("file") == [("toy-exam-twice.hand-in.txt", f"{written}\n".encode())]


def test_a_wrong_answer_is_signed_alike() -> None:
    course = served()
    right, wrong = (tab_of(course=course) for _ in range(2))
    right.do(HandIn("exam", "twice", right_answer(course.course, "s1")))
    wrong.do(HandIn("exam", "twice", "0.01"))
    told = [[words("en") for words in tab.view.sentences()] for tab in (right, wrong)]
    assert told[0] == told[1] and judged(course, wrong.picture.state.hand_ins[EXAM]) == 0


def test_a_late_hand_in_is_signed_and_called_late() -> None:
    tab = tab_of(course=served(DEADLINE + 1))
    tab.do(HandIn("exam", "twice", "1"))
    assert tab.view.scolded()[-1] == SIGNED_LATE and EXAM in tab.picture.state.hand_ins
    on_time = tab_of(course=served(DEADLINE + 0.9))
    on_time.do(HandIn("exam", "twice", "1"))
    assert not on_time.view.scolded()


@pytest.mark.parametrize("key", ["", "=1+1", "<b>", "s" * 61])
def test_without_a_key_that_a_list_can_hold_nothing_is_signed(key: str) -> None:
    tab = tab_of(key=key)
    tab.do(HandIn("exam", "twice", "1"))
    assert tab.view.scolded()[-1] == NEEDS_KEY and not tab.picture.state.hand_ins


def test_what_the_course_does_not_ask_is_not_signed() -> None:
    for lesson, kind, item in (("drill", "exam", "twice"), ("other", "exam", "twice"), ("toy", "task", "low"), ("toy", "exam", "none")):
        tab = tab_of(lesson)
        tab.do(HandIn(kind, item, "1"))  # type: ignore[arg-type]
        assert tab.view.scolded()[-1] == NOT_IN_COURSE and not tab.picture.state.hand_ins
    tab.do(SaveHandIn("none"))
    assert tab.view.scolded()[-1] == NOTHING_SIGNED
    plain = Tab()
    plain.do(HandIn("exam", "twice", "1"))
    assert plain.view.scolded()[-1] == NOT_IN_COURSE


@pytest.mark.parametrize("said", ["", "much", None])
def test_what_is_no_number_is_not_signed(said: object) -> None:
    tab = tab_of()
    tab.do(HandIn("exam", "twice", said))
    assert len(tab.view.scolded()) == 1 and not tab.picture.state.hand_ins


def test_a_task_is_signed_only_when_the_design_solves_it_on_the_lessons_own_plant() -> None:
    course = served()
    kept = json.dumps({"version": 2, "lesson": "toy", "language": "en", "key": "s1", "desks": {"toy": {
        "version": 1, "lesson": "toy", "knobs": {}, "tasks": {"high": [0, True, True]}}}})
    tab = Tab(toys(), "toy", sealed=True, course=course)
    tab.session._show.recalled = False
    tab.session.restore(kept)
    tab.do(SetKey("s1"))
    tab.do(SetWord(word(course.course, "s1")))
    verdict = tab.picture.state.tasks["high"].verdict
    assert verdict is not None and verdict.solved  # as the browser claims
    tab.do(HandIn("task", "high"))
    assert tab.view.scolded()[-1] == NOT_SOLVED and not tab.picture.state.hand_ins
    tab.set(gain=6.0)
    tab.do(HandIn("task", "high"))
    assert judged(course, tab.picture.state.hand_ins[TASK]) == 5.0
    adapted = {"toy": replace(toys()["toy"], adapt=lambda lesson, model: lesson)}
    other = Tab(adapted, "toy", sealed=True, course=course, plant=example("motor"))
    other.do(SetKey("s1"))
    other.do(SetWord(word(course.course, "s1")))
    other.set(gain=6.0)
    assert other.picture.design.plant
    other.do(HandIn("task", "high"))
    assert other.view.scolded()[-1] == OWN_PLANT and not other.picture.state.hand_ins


def test_a_course_shows_results_and_solutions_only_where_its_file_says_so() -> None:
    for lesson, practice in (("toy", False), ("drill", True), ("other", False)):
        tab, exam = tab_of(lesson), toys()[lesson].exams[0]
        tab.do(OpenState(write_token(toys()[lesson], SavedState(toys()[lesson].start()))))
        tab.do(WithholdResults(False))
        assert tab.view.scolded()[-1] == COURSE_DECIDES
        assert is_withheld(tab.picture.state, lesson, exam) is not practice
        tab.do(AnotherVariant("twice"))
        assert present_variant(tab.picture.state, lesson, exam) == (2 if practice else 0)
        tab.do(AnswerExam("twice", "1"))
        assert (present_verdict(tab.picture.state, lesson, exam) is not None) is practice
        tab.do(ShowSolution("high"))
        shown = tab.picture.state.tasks.get("high", TaskState()).solution
        assert shown is practice and (practice or tab.view.scolded()[-1] == COURSE_NO_SOLUTION)
        assert tab.picture.state.offers_solution(lesson, "low") is False  # a task that the file does not name


def test_a_reload_brings_back_signed_hand_ins_and_no_others() -> None:
    course = served()
    tab = tab_of(course=course)
    tab.do(HandIn("exam", "twice", "1"))
    kept = json.loads(tab.view.kept or "")
    mine = tab.picture.state.hand_ins[EXAM]
    assert kept["hand_ins"] == {EXAM: mine}
    for said, found in (({EXAM: mine}, {EXAM: mine}), ({TASK: mine}, {}), ({EXAM: mine[:-1] + "_"}, {}), ({EXAM: 3}, {}), ("no", {}),
                        ({EXAM: '"><script>'}, {})):
        again = Session(tab.lessons, FakeView(), "toy", sealed=True, course=course)
        again.restore(json.dumps({**kept, "hand_ins": said}))
        again.open()
        assert again.picture is not None and again.picture.state.hand_ins == found
    without = Session(tab.lessons, FakeView(), "toy")
    without.restore(json.dumps(kept))
    without.open()
    assert without.picture is not None and without.picture.state.hand_ins == {}


def test_nothing_that_a_tab_keeps_or_says_holds_the_secret() -> None:
    course = served()
    tab = tab_of(course=course)
    tab.do(HandIn("exam", "twice", "1"))
    tab.do(SaveHandIn(EXAM))
    said = " ".join([tab.view.kept or "", repr(tab.picture.state), *(words("en") for words in tab.view.sentences()),
                     *(f"{name} {content!r}" for name, content in tab.view.of("file")), *map(str, tab.view.addresses)])
    keys = course.course.keys
    assert SECRET not in said and not re.search("|".join((keys._numbers.hex(), keys._signing.hex())), said)
    assert token(course.course)[:5] in said
