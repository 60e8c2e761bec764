"""Followers see what the presenter does and cannot change it; copies of their own and other presenters leave the lecture alone."""

from __future__ import annotations

import html
import re
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import HTTPRedirectHandler, Request, build_opener

import pytest
from client import WireTab
from lecture import Enter, Present, ask, card, counts, hand, number_of_the_vote, opened, part, say

from observer_lab.classroom.room_store import RoomStore
from observer_lab.lessons import LESSONS
from observer_lab.page.room.follower import preferred_language
from observer_lab.page.screen.server import LabServer
from observer_lab.session.commands.commands import CheckNextTask
from observer_lab.session.commands.guide import SetMode


def test_a_follower_sees_scene_knob_and_run_of_the_presenter(enter: Enter, present: Present, server: LabServer) -> None:
    presenter, follower = present(), enter()
    follower.until(lambda: 'data-scene="predict"' in card(follower), "the presenter's scene")
    assert "/board/observer" in follower.nodes and "/floor" in follower.nodes
    ask(presenter, "turn:-1")
    follower.until(lambda: card(follower) != "" and 'data-scene="predict"' not in card(follower), "the scene before")
    shown = len(follower.messages)
    presenter.press("▶ play")
    follower.until(lambda: any("// play.js" in (source := m.get("source", "")) and '"begins": true' in source
                               for m in follower.messages[shown:]), "the run")
    assert len(server.sessions) == 1, "a follower has no session"


def test_what_a_follower_sends_changes_nothing(enter: Enter, present: Present, server: LabServer) -> None:
    presenter, follower = present(), enter()
    follower.until(lambda: card(follower), "the card")
    session = next(iter(server.sessions.values()))
    before = session.picture
    assert before is not None
    for uuid, widget in list(follower.widgets.items()):
        for value in (1.0, "turn:1", "mode:lab", True):
            follower.send("GuiUpdateMessage", uuid=uuid, updates={"value": value, **({} if value == 1.0 else {"visible": False})})
        follower.send("GuiUpdateMessage", uuid=uuid, updates={"content": widget["type"]})
    for name in ("/board/observer", "/board/controller/pole0"):
        follower.send("SceneNodeDragMessage", phase="update", name=name, instance_index=None, start_position=(0, 0, 0),
                      start_screen_pos=(0.5, 0.5), end_position=(1, 0, 0), end_screen_pos=(0.5, 0.5), button="left", modifier=None,
                      owner="0")
    for words in ("turn:1", "scene:0", "mode:lab", "vote:open", "vote:close", "vote:x:y:z", "vote:1", "hands", "pole:", "ask:x"):
        say(follower, words)
        follower.send("GuiUpdateMessage", uuid=hand(presenter), updates={"value": words})
    say(follower, "slower")  # behind all of that
    follower.until(lambda: follower.notes, "an answer to the hand")
    presenter.settle()
    after = session.picture
    assert after is not None and after.design == before.design
    assert (after.state.scene, after.state.mode) == (before.state.scene, before.state.mode)
    say(follower, "slower")


@pytest.mark.parametrize("path", ["/?present=", "/?present=guessed-word", "/?role=presenter", "/?present=../../etc", "/?follow=1"])
def test_the_role_is_not_taken_without_the_word(enter: Enter, server: LabServer, present: Present, path: str) -> None:
    present()
    stranger = enter(path=path, word="" if "follow" not in path else "another-word-of-a-stranger")
    stranger.until(lambda: card(stranger), "the follower's card")
    assert "data-to=" not in "".join(str(w["props"].get("content")) for w in stranger.widgets.values()), "no button of a presenter"
    assert len(server.sessions) == 1


def test_the_presenters_link_is_exchanged_for_a_cookie_of_its_own(server: LabServer, tmp_path: Path) -> None:
    class Stay(HTTPRedirectHandler):
        def redirect_request(self, *_: object) -> None:
            return None
    word = RoomStore(tmp_path).secret
    with pytest.raises(HTTPError) as answer:
        build_opener(Stay).open(Request(f"{server.url}/?present={word}"), timeout=10)
    assert answer.value.code == 303 and word not in answer.value.headers["Location"]
    cookie = answer.value.headers["Set-Cookie"]
    assert cookie.startswith("observer-lab-0-present=") and "HttpOnly" in cookie and "SameSite=Strict" in cookie


def test_a_copy_of_ones_own_begins_at_the_same_state_and_leaves_the_lecture_alone(enter: Enter, present: Present,
                                                                                  server: LabServer) -> None:
    presenter, follower = present(), enter()
    follower.until(lambda: "?own=1#1." in part(follower, '<div class="ol-way"'), "the link to one's own copy")
    assert re.search(r'href="\?own=1#(1\.[\w-]+)"', part(follower, '<div class="ol-way"'))
    before = card(presenter)
    own = enter(path="/?own=1")
    own.settle()
    assert 'href="./"' in part(own, '<p class="ol-back"')
    ask(own, "turn:1")
    own.settle()
    presenter.settle()
    assert card(presenter) == before and len(server.sessions) == 2


def test_the_presenter_sees_how_many_are_here_where_what_they_fail_at_and_raised_hands(enter: Enter, present: Present,
                                                                                       server: LabServer) -> None:
    presenter, follower, own = present(), enter(), enter(path="/?own=1")
    follower.until(lambda: card(follower), "the card")
    own.settle()
    say(follower, "slower")
    presenter.until(lambda: "2 here · following: 1" in counts(presenter) and "slower, please: 1" in counts(presenter), "the counts")
    assert LESSONS["separation"].words["en"].title in counts(presenter)
    server.sessions[max(server.sessions)].post(CheckNextTask())
    presenter.until(lambda: "tried without success by 1" in counts(presenter), "the task that was not solved")
    ask(presenter, "hands")
    presenter.until(lambda: "slower, please" not in counts(presenter), "lowered hands")


def test_who_comes_later_gets_the_whole_page_and_who_comes_first_waits(tmp_path: Path) -> None:
    server = opened(tmp_path)
    try:
        with WireTab(server.url) as early:
            early.until(lambda: part(early, '<h1 class="ol-scene">'), "that the lecture has not begun")
            with WireTab(server.url, word=RoomStore(tmp_path).secret) as presenter:
                presenter.settle()
                early.until(lambda: card(early), "the card")
                with WireTab(server.url) as late:
                    late.until(lambda: card(late) == card(early) and set(late.nodes) == set(early.nodes), "the same card and scene")
    finally:
        server.stop()


def test_a_follower_reads_the_language_of_its_browser() -> None:
    asked = {"zh-CN,zh;q=0.9": "zh", "de,zh;q=0.5": "zh", "fr": "en", "": "en", "EN-gb": "en"}
    assert {words: preferred_language(words, "en") for words in asked} == asked


def test_a_code_that_no_other_machine_can_open_says_so(enter: Enter) -> None:
    own = enter(path="/?own=1")
    own.settle()
    ask(own, "take")
    own.until(lambda: "Only this computer can open this link" in part(own, '<div class="ol-take"'), "the sentence beside the code")


def test_two_pages_of_a_presenter_follow_each_other_and_one_leads_on_when_the_other_leaves(enter: Enter, present: Present) -> None:
    first, follower = present(), enter()
    follower.until(lambda: 'data-scene="predict"' in card(follower), "the first presenter's scene")
    second = present()
    first.until(lambda: any("Another page of yours" in note for note in first.notes), "that another page presents")
    _, here, there, *_ = (scene.id for scene in LESSONS["separation"].path)
    for acts, scene, other in ((first, 1, second), (second, 2, first)):
        ask(acts, f"scene:{scene}")
        stands = f'data-scene="{(here, there)[scene - 1]}"'
        for page in (acts, other, follower):
            page.until(lambda page=page, stands=stands: stands in card(page), "the scene of the page that acts")
    second.close()
    ask(first, "scene:1")
    follower.until(lambda: f'data-scene="{here}"' in card(follower), "the page that is left leads")


def test_a_second_page_of_the_presenter_gets_knobs_answer_and_mode(present: Present) -> None:
    first, second = present(), present()
    second.settle()
    ask(first, "option:1")
    second.until(lambda: "ol-chosen" in card(second), "the answer on the second page")
    second.settle()
    ask(second, "mode:lab")
    for page in (second, first):
        page.until(lambda page=page: not card(page) and page.mark(), "the lab on both pages")
        page.settle()
    first.update("stiffness error in the model [%]", value=12.0)
    second.until(lambda: second.value("stiffness error in the model [%]") == 12.0, "the knob on the second page")


@pytest.mark.parametrize("tells", [0, 1], ids=["first page", "page that leads"])
def test_an_answer_that_either_page_tells_is_shown_to_the_class(tells: int, enter: Enter, present: Present) -> None:
    pages, follower = (present(), present()), enter()
    ask(pages[tells], "vote:open")
    number = number_of_the_vote(follower)
    ask(pages[tells], "vote:close")
    pages[tells].until(lambda: "Reveal the answer" in counts(pages[tells]), "the closed vote")
    ask(pages[tells], f"vote:reveal:{number}")
    follower.until(lambda: "ol-right" in card(follower), "the right option at the follower")
    for page in pages:
        page.until(lambda page=page: "ol-true" in card(page), "the right option on both pages")


def test_in_the_lab_followers_see_the_knobs_that_the_presenter_has_moved(enter: Enter, present: Present,
                                                                         server: LabServer) -> None:
    presenter, follower = present(), enter()
    follower.until(lambda: card(follower), "the card")
    ask(presenter, "mode:lab")
    question = html.escape(LESSONS["separation"].words["en"].question)
    follower.until(lambda: question in card(follower), "the lesson's question")
    presenter.update("stiffness error in the model [%]", value=12.0)
    follower.until(lambda: "<dd>12 %</dd>" in part(follower, '<dl class="ol-knobs"'), "the moved knob")
    server.sessions[max(server.sessions)].post(SetMode("guide"))
    follower.until(lambda: "data-scene=" in card(follower), "the path again")
