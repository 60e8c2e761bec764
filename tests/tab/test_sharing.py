"""A link opens in a tab exactly what it says, whatever lies there; the address bar follows; a bad one is one sentence."""

from __future__ import annotations

import json

import pytest
from fakes import BROKEN, FORBIDDEN, Clock, FakeView, Tab, toy

from observer_lab.course.figures.records import tab_names
from observer_lab.course.scenes import Read, entry_values
from observer_lab.lessons import LESSONS as COURSE
from observer_lab.session.commands.commands import (
    MemoryRecalled,
    OpenLesson,
    OpenState,
    PlaceOpened,
    Predict,
    Redo,
    Reset,
    SaveState,
    SetKnobs,
    SetLanguage,
    ToggleDownloads,
    Undo,
)
from observer_lab.session.commands.guide import GoToScene
from observer_lab.session.commands.room import LeadShown
from observer_lab.session.handlers.guide import STEP_S, STEPS
from observer_lab.session.session import Session
from observer_lab.session.state.saved_state import SavedState, write_state
from observer_lab.session.state.token import DAMAGED_LINK, read_token, write_token
from observer_lab.session.state.view import Picture
from observer_lab.text import text

LESSONS = {name: toy(name) for name in ("first", "second")}


def token(lesson: str = "second", language: str = "zh", **knobs: object) -> str:
    design = LESSONS[lesson].apply(LESSONS[lesson].start(), {"gain": 3.5, **knobs})
    return write_token(LESSONS[lesson], SavedState(design, language, True, camera=(1.0, -9.0, 2.0, 0.0, 0.0, 1.0)))


def fresh(answer: tuple[object, ...], **options: object) -> tuple[Session, FakeView]:
    """A tab whose browser answers so before the lesson stands."""
    view = FakeView()
    session = Session(LESSONS, view, "first", **options)
    session.restore(*answer)
    session.open()
    return session, view


def test_a_link_opens_its_state_in_a_fresh_browser_and_the_prediction_stays_veiled() -> None:
    session, view = fresh((None, token(), False))
    picture = session.picture
    assert picture is not None and picture.design["gain"] == 3.5 and picture.lesson.id == "second"
    assert (picture.state.language, picture.state.lecture, picture.state.predicted) == ("zh", True, None)
    assert picture.state.camera == (1.0, -9.0, 2.0, 0.0, 0.0, 1.0)
    assert view.of("say") == []


def test_the_address_bar_follows_what_is_done() -> None:
    tab = Tab(LESSONS)
    tab.set(gain=2.0)
    assert [address for address in tab.view.addresses if read_token(address[0], LESSONS).design["gain"] == 2.0] == []
    tab.rest()
    written, lesson, asked = tab.view.addresses[-1]
    assert read_token(written, LESSONS).design == tab.picture.design and (lesson, asked) == ("first", 0)
    tab.do(SetLanguage("zh"))
    tab.do(OpenLesson("second"))
    written, lesson, _ = tab.view.addresses[-1]
    assert lesson == "second" and read_token(written, LESSONS).language == "zh"


def test_the_address_bar_is_written_before_the_page_says_that_it_rests(monkeypatch: pytest.MonkeyPatch) -> None:
    """Scripts and tests wait for a page that rests, and then read its address."""
    tab, same = Tab(LESSONS), list[bool]()
    show = tab.view.show

    def shown(picture: Picture) -> None:
        if picture.resting:
            same.append(read_token(tab.view.addresses[-1][0], LESSONS).design == picture.design)
        show(picture)
    monkeypatch.setattr(tab.view, "show", shown)
    for edit in (SetKnobs({"gain": 2.0}), SetKnobs({"gain": 3.0}), Undo(), SetKnobs({"gain": FORBIDDEN}), Redo(), Reset()):
        tab.do(edit)
        tab.rest()
    assert len(same) >= 5 and all(same)


def test_nothing_is_written_into_the_address_bar_before_what_stands_there_is_known() -> None:
    view = FakeView(answers=False)
    session = Session(LESSONS, view, "first")
    session.open()
    assert view.addresses == []
    session.post(MemoryRecalled(None, token(), False))
    session.step()
    assert session.picture is not None and session.picture.design["gain"] == 3.5
    assert read_token(view.addresses[-1][0], LESSONS).design == session.picture.design


def test_a_link_opened_over_ones_own_work_is_one_step_of_undo_away_and_keeps_the_prediction() -> None:
    tab = Tab(LESSONS)
    tab.set(gain=6.0)
    tab.do(Predict(1))
    tab.do(OpenState(token("first"), 3))
    assert tab["gain"] == 3.5 and tab.picture.state.predicted == 1
    assert tab.view.addresses[-1][2] == 3 and tab.view.looks == (1.0, -9.0, 2.0, 0.0, 0.0, 1.0)
    tab.do(Undo())
    assert tab["gain"] == 6.0


def test_a_reload_goes_on_where_the_tab_was_and_its_own_address_changes_nothing() -> None:
    tab = Tab(LESSONS)
    tab.do(Predict(1))
    tab.set(gain=6.0)
    tab.rest()
    session, view = fresh((tab.view.kept, tab.view.addresses[-1][0], True))
    picture = session.picture
    assert picture is not None and picture.design["gain"] == 6.0 and picture.state.predicted == 1
    assert (picture.steps, picture.at) == (tab.picture.steps, tab.picture.at), "no step more than the tab had"
    assert view.of("say") == []


def test_another_link_in_the_same_tab_is_opened_over_what_was_kept() -> None:
    tab = Tab(LESSONS)
    tab.set(gain=6.0)
    tab.rest()
    session, _ = fresh((tab.view.kept, token("first"), False))
    assert session.picture is not None and session.picture.design["gain"] == 3.5 and session.picture.state.can_undo


def test_a_browser_without_storage_is_restored_by_its_address() -> None:
    session, _ = fresh((None, token(), True))
    assert session.picture is not None and session.picture.design["gain"] == 3.5


@pytest.mark.parametrize("words", ["1.AAAA", "x", "", "{}", b"\xff", b"{", 3, None, ["1.AAAA"], token(gain=FORBIDDEN), token(gain=BROKEN),
                                   "[" * 5000 + "{"])
def test_what_cannot_be_opened_is_one_sentence_and_changes_nothing(words: object) -> None:
    tab = Tab(LESSONS)
    tab.set(gain=6.0)
    before = tab.picture.design
    tab.do(OpenState(words))
    assert len(tab.view.scolded()) == 1 and tab.picture.design == before and tab.picture.lesson.id == "first"


def test_a_bad_link_in_a_fresh_browser_opens_the_page_and_says_one_sentence_on_it() -> None:
    session, view = fresh((None, "1.AAAA", False))
    assert session.picture is not None and session.picture.lesson.id == "first"
    assert view.scolded() == [DAMAGED_LINK] and [name for name, _ in view.calls].index("build") < [name for name, _ in view.calls].index(
        "say"
    )


def test_a_server_opens_its_state_for_those_who_bring_none(monkeypatch: pytest.MonkeyPatch) -> None:
    for kept, wanted in (((None, "", False), 3.5), ((None, token(gain=4.0), False), 4.0)):
        view = FakeView(answers=False)
        session = Session(LESSONS, view, "first", state=token())
        session.post(MemoryRecalled(*kept))
        monkeypatch.setattr("observer_lab.session.session.start_worker", lambda mailbox, begin, step, stop: begin())
        session.start()
        assert session.picture is not None and session.picture.design["gain"] == wanted


def test_the_state_is_handed_over_as_a_file_that_opens_again() -> None:
    tab = Tab(LESSONS)
    tab.set(gain=6.0)
    tab.do(SaveState())
    name, content = tab.view.of("file")[-1]
    assert name == "first.json" and json.loads(content)["knobs"] == {"gain": "6"}
    tab.set(gain=1.0)
    tab.do(OpenState(content))
    assert tab["gain"] == 6.0
    tab.do(OpenState(write_state(LESSONS["second"], SavedState(LESSONS["second"].start()))))
    assert tab.picture.lesson.id == "second"


def test_the_dialog_offers_the_present_state() -> None:
    tab = Tab(LESSONS)
    tab.set(gain=6.0)
    tab.do(ToggleDownloads())
    assert read_token(tab.view.of("offer")[-1], LESSONS).design == tab.picture.design


@pytest.mark.parametrize("tab_number, step, kept", [
    (1, 0, ("Error", 0)), (0, -1, (None, None)), (99, 99, (None, None)), ("1", None, (None, None)), (-1, -1, (None, None))])
def test_the_opened_tab_and_step_travel(tab_number: object, step: object, kept: tuple[object, object]) -> None:
    def figures(outcome):
        (figure,) = toy().figures(outcome)
        return figure, type(figure)("e", figure.title, figure.x, figure.curves, tab=text("Error"))
    tab = Tab({"first": toy("first", figures=figures)})
    assert [name("en") for name in tab_names(tab.picture.figures)] == ["Time", "Error"]
    tab.do(PlaceOpened(tab_number, step))
    saved = read_token(tab.view.addresses[-1][0], tab.lessons)
    assert (saved.tab, saved.step) == kept


def test_a_link_that_names_a_scene_opens_it_with_the_design_as_it_was() -> None:
    first = Session(COURSE, FakeView(), "separation", mode="guide")
    first.open()
    for edit in (GoToScene(3), SetKnobs({"stiffness_error": 7.0})):
        first.post(edit)
        first.step(0.0)
    picture = first.picture
    assert picture is not None and picture.design["stiffness_error"] == 7.0
    second = Session(COURSE, FakeView(), "kalman", mode="guide")
    second.restore(None, write_token(picture.lesson, picture.saved(picture.design, None)))
    second.open()
    opened = second.picture
    assert opened is not None and (opened.lesson.id, opened.state.scene, opened.design) == ("separation", 3, picture.design)


READINGS = [(lesson.id, k) for lesson in COURSE.values() for k, scene in enumerate(lesson.path)
            if isinstance(scene.do, Read) and scene.play]


def by_link(lesson: str, scene: int) -> str:
    """A link to a scene as it begins, which says nothing of what was done there."""
    start, path = COURSE[lesson].start(), COURSE[lesson].path
    return write_token(COURSE[lesson], SavedState(COURSE[lesson].apply(start, entry_values(path, scene, start)), mode="guide",
                                                  scene=path[scene].id))


def after(tab: Tab) -> tuple[object, ...]:
    """The picture of a scene at the end of its performance."""
    for _ in range(STEPS + 2):
        tab.clock.advance(STEP_S + 0.01)
        tab.session.step(0.0)
    state = tab.picture.state
    return tab.picture.design, state.performance, state.scene, state.done, state.playing


@pytest.mark.parametrize(("lesson", "scene"), READINGS)
def test_a_scene_to_be_read_is_performed_by_a_link_as_by_its_dot(lesson: str, scene: int) -> None:
    """In a fresh browser, over another lesson, and over the same scene that was read before: the card says that the page changes."""
    by_dot = Tab(COURSE, lesson, mode="guide")
    by_dot.do(GoToScene(scene))
    read = COURSE[lesson].path[scene]
    want = after(by_dot)
    assert want[0] == COURSE[lesson].apply(by_dot.picture.design, read.play) and read.id in by_dot.picture.state.done
    over, fresh_one = Tab(COURSE, next(id for id in COURSE if id != lesson), mode="guide"), Tab.__new__(Tab)
    fresh_one.lessons, fresh_one.view, fresh_one.clock = dict(COURSE), FakeView(), Clock()
    fresh_one.session = Session(COURSE, fresh_one.view, next(iter(COURSE)), clock=fresh_one.clock, mode="guide")
    fresh_one.session.restore(None, by_link(lesson, scene))
    fresh_one.session.open()
    for tab in (over, by_dot):
        tab.do(OpenState(by_link(lesson, scene)))
    for tab in (fresh_one, over, by_dot):
        assert tab.picture.state.performance is not None
        design, performance, at, done, playing = after(tab)
        assert (design, performance, at, playing) == (want[0], None, scene, want[4]) and done[read.id] == want[0]


@pytest.mark.parametrize(("lesson", "scene"), READINGS)
def test_a_link_to_a_reading_that_is_over_or_was_changed_opens_as_it_was(lesson: str, scene: int) -> None:
    tab = Tab(COURSE, lesson, mode="guide")
    tab.do(GoToScene(scene))
    after(tab)
    copied = tab.view.addresses[-1][0]
    assert read_token(copied, COURSE).answered == -1
    changed = SavedState(COURSE[lesson].start(), mode="lab", scene=COURSE[lesson].path[scene].id)
    for token, design in ((copied, tab.picture.design), (write_token(COURSE[lesson], changed), changed.design)):
        session = Session(COURSE, FakeView(), "kalman", mode="guide")
        session.restore(None, token)
        session.open()
        assert session.picture is not None and session.picture.design == design and session.picture.state.performance is None


@pytest.mark.parametrize(("lesson", "scene"), READINGS)
def test_a_page_that_follows_performs_nothing_by_itself(lesson: str, scene: int) -> None:
    tab = Tab(COURSE, lesson, mode="guide")
    tab.do(LeadShown(by_link(lesson, scene)))
    assert tab.picture.state.scene == 0, "a hand has just been here"
    tab.rest()
    tab.clock.advance(60.0)
    tab.do(LeadShown(by_link(lesson, scene)))
    assert tab.picture.state.scene == scene and tab.picture.state.performance is None
