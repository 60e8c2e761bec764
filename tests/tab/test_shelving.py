"""A browser keeps designs under names, and what was done in one tab is there in the next; nothing of it is trusted."""

from __future__ import annotations

import json

from fakes import BROKEN, FakeView, Tab, toy

from observer_lab.session.commands.commands import MemoryRecalled, OpenLesson, OpenState, Predict, SetLanguage, Undo
from observer_lab.session.commands.files import ClearBrowser, DeleteSavedDesign, OpenSavedDesign, PinDesign, SaveDesign
from observer_lab.session.handlers.kept_designs import NAME_IT, NO_ROOM, NO_SUCH, TOO_MANY_SAVED
from observer_lab.session.session import Session
from observer_lab.session.state.saved_state import MAX_SAVED_DESIGNS, SavedState, read_saved_designs
from observer_lab.session.state.token import write_token

LESSONS = {name: toy(name) for name in ("first", "second")}


def new_tab(earlier: str | None, shelf: str | None = None, token: str = "", **options: object) -> Session:
    """A tab of a browser that has been here before."""
    session = Session(LESSONS, FakeView(), "first", **options)  # type: ignore[arg-type]
    session.post(MemoryRecalled(None, token, False, earlier, shelf))
    session.open()
    session.step()
    return session


def worked() -> Tab:
    tab = Tab(LESSONS)
    tab.do(OpenLesson("second"))
    tab.set(gain=6.0)
    tab.do(Predict(1))
    tab.do(PinDesign())
    tab.do(SetLanguage("zh"))
    tab.rest()
    return tab


def test_a_design_is_kept_under_a_name_opened_anywhere_and_removed() -> None:
    tab = worked()
    tab.do(SaveDesign("  my   design "))
    (name, words), = tab.view.of("shelve")
    assert name == "my design" and [kept.name for kept in tab.picture.state.shelf] == ["my design"]
    session = new_tab(None, json.dumps({name: words}))
    session.post(OpenSavedDesign("my design"))
    session.step()
    picture = session.picture
    assert picture is not None and picture.lesson.id == "second" and picture.design["gain"] == 6.0
    assert picture.state.language == "en", "the page stays as it is"
    tab.set(gain=2.0)
    tab.do(SaveDesign("my design"))
    assert len(tab.picture.state.shelf) == 1
    tab.set(gain=1.0)
    tab.do(OpenSavedDesign("my design"))
    assert tab["gain"] == 2.0
    tab.do(Undo())
    assert tab["gain"] == 1.0
    tab.do(DeleteSavedDesign("my design"))
    assert tab.view.of("shelve")[-1] == ("my design", "") and tab.picture.state.shelf == ()
    for wrong, why in ((OpenSavedDesign("my design"), NO_SUCH), (DeleteSavedDesign(3), NO_SUCH), (SaveDesign(" "), NAME_IT)):
        tab.do(wrong)
        assert tab.view.scolded()[-1] == why
    tab.set(hand=[(k / 100 + 1e-9 * k, 0.123456789 * (k % 8)) for k in range(400)])
    for k in range(20):
        tab.do(SaveDesign(f"long {k}"))
    assert tab.view.scolded()[-1] == NO_ROOM and 3 < len(tab.picture.state.shelf) < 20


def test_a_new_tab_goes_on_where_the_last_one_was() -> None:
    before = worked()
    picture = new_tab(before.view.kept).picture
    assert picture is not None and picture.lesson.id == "second" and picture.design == before.picture.design
    assert (picture.state.predicted, picture.state.language, len(picture.pinned)) == (1, "zh", 1)


def test_a_link_or_a_server_that_insists_comes_before_what_the_last_tab_did() -> None:
    kept = worked().view.kept
    link = write_token(LESSONS["first"], SavedState(LESSONS["first"].apply(LESSONS["first"].start(), {"gain": 3.0})))
    linked, insisted, stated = new_tab(kept, token=link), new_tab(kept, insists=True), new_tab(kept, state=link)
    for session, lesson in ((linked, "first"), (insisted, "first"), (stated, "first")):
        assert session.picture is not None and session.picture.lesson.id == lesson
        session.post(OpenLesson("second"))
        session.step()
        assert session.picture.design["gain"] == 6.0 and session.picture.state.predicted == 1, "its work is not lost"


def test_what_a_tab_kept_itself_comes_before_what_others_did() -> None:
    tab = Tab(LESSONS)
    tab.set(gain=2.0)
    tab.rest()
    session = Session(LESSONS, FakeView(), "first")
    session.post(MemoryRecalled(tab.view.kept, "", False, worked().view.kept))
    session.open()
    session.step()
    assert session.picture is not None and session.picture.lesson.id == "first" and session.picture.design["gain"] == 2.0


def test_a_browser_forgets_everything_when_told_to() -> None:
    tab = worked()
    tab.do(SaveDesign("mine"))
    tab.do(ClearBrowser())
    state = tab.picture.state
    assert tab.view.of("wipe") == [None] and (state.shelf, state.pins, state.predicted, state.key) == ((), (), None, "")
    assert tab.picture.design == LESSONS["second"].start()
    tab.do(OpenLesson("first"))
    assert tab.view.kept is not None and set(json.loads(tab.view.kept)["desks"]) == {"first", "second"}
    assert '"6"' not in tab.view.kept, "the gain that was worked with; a name drawn at random may begin so"


def test_what_comes_from_storage_is_judged() -> None:
    good = json.dumps({"version": 1, "lesson": "first", "knobs": {}})
    for wrong in ("", "{", "[]", "3", "null", "[" * 50_000, json.dumps({"a": 3}), json.dumps({"a": "{"}), json.dumps({"a": "[]"}),
                  json.dumps({"": good}), json.dumps({"x" * 99: good}), json.dumps({"a\n": good}),
                  json.dumps({"a": good.replace("first", "nowhere")})):
        assert read_saved_designs(wrong, LESSONS) == ()
    many = json.dumps({f"d{k}": good for k in range(MAX_SAVED_DESIGNS + 9)})
    assert len(read_saved_designs(many, LESSONS)) == MAX_SAVED_DESIGNS
    session = new_tab("{", many.replace('"d0"', '"broken"', 1).replace("{}", '{\\"gain\\": \\"' + str(BROKEN) + '\\"}', 1))
    view: FakeView = session._show.view  # type: ignore[assignment]
    for edit in (OpenSavedDesign("broken"), SaveDesign("one more"), OpenState("{")):
        session.post(edit)
        session.step()
    assert len(view.scolded()) == 3 and TOO_MANY_SAVED in view.scolded()
    assert session.picture is not None and session.picture.design == LESSONS["first"].start()
