"""A room over the real protocol: followers see the lecture and cannot change it, votes count once, a restart loses nothing."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import HTTPRedirectHandler, Request, build_opener

import pytest
from client import WireTab, empty

from observer_lab.classroom.class_runs import seeds_of
from observer_lab.classroom.kept_room import Place, open_room
from observer_lab.classroom.room_store import RoomStore
from observer_lab.classroom.votes import HIDDEN_BELOW
from observer_lab.lessons import LESSONS
from observer_lab.page.access.tokens import PRESENTER_FIELD, AccessToken
from observer_lab.page.room.follower import read_ballot
from observer_lab.page.room.lecture_room import LectureRoom, preferred_language
from observer_lab.page.screen.server import LabServer
from observer_lab.session.commands.commands import CheckNextTask
from observer_lab.session.commands.guide import SetMode

PREDICT = next(k for k, scene in enumerate(LESSONS["separation"].path) if scene.id == "predict")
Enter = Callable[..., WireTab]


def opened(place: Place, worker: int = 0, lesson: str = "separation") -> LabServer:
    word = open_room(place).secret
    return LabServer(LESSONS, port=0, lesson=lesson, mode="guide", room=LectureRoom(place, worker, "en"),
                     presenter=AccessToken(word, 0, PRESENTER_FIELD))


def part(tab: WireTab, opening: str) -> str:
    """What a tab shows in the element that opens so; empty where it has none."""
    contents = (str(widget["props"].get("content")) for widget in tab.widgets.values())
    return next((content for content in contents if content.startswith(opening)), "")


def card(tab: WireTab) -> str:
    return part(tab, '<section class="ol-card"')


def hand(tab: WireTab) -> str:
    """The widget for which a presenter's buttons answer."""
    found = re.search(r'data-to="([^"]+)"', part(tab, '<div class="ol-head'))
    assert found is not None
    return found[1]


def ask(tab: WireTab, value: str) -> None:
    tab.send("GuiUpdateMessage", uuid=hand(tab), updates={"value": value})


def say(tab: WireTab, value: str) -> None:
    """What a follower's page sends when one of its buttons is pressed."""
    source = next(m["source"] for m in tab.messages if m["type"] == "RunJavascriptMessage" and "// room.js" in m["source"])
    found = re.search(r'"hand": "([^"]+)"', source)
    assert found is not None
    tab.send("GuiUpdateMessage", uuid=found[1], updates={"value": value})


def number_of_the_vote(tab: WireTab) -> int:
    tab.until(lambda: 'data-room="vote:' in card(tab), "an open vote")
    found = re.search(r'data-room="vote:(\d+):0"', card(tab))
    assert found is not None
    return int(found[1])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("room")


@pytest.fixture(scope="module")
def server(folder: Path) -> Iterator[LabServer]:
    server = opened(folder)
    yield server
    server.stop()


@pytest.fixture
def enter(server: LabServer) -> Iterator[Enter]:
    tabs: list[WireTab] = []

    def make(**options: object) -> WireTab:
        tabs.append(WireTab(server.url, **options))  # type: ignore[arg-type]
        return tabs[-1]
    yield make
    for tab in tabs:
        tab.close()
    empty(server)


@pytest.fixture
def present(enter: Enter, folder: Path) -> Callable[[], WireTab]:
    def make() -> WireTab:
        tab = enter(word=RoomStore(folder).secret)
        tab.settle()
        ask(tab, f"scene:{PREDICT}")
        tab.until(lambda: 'data-scene="predict"' in card(tab), "the question's scene")
        tab.settle()
        return tab
    return make


def test_a_follower_sees_scene_knob_and_run_of_the_presenter(enter: Enter, present: Callable[[], WireTab], server: LabServer) -> None:
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


def test_what_a_follower_sends_changes_nothing(enter: Enter, present: Callable[[], WireTab], server: LabServer) -> None:
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
def test_the_role_is_not_taken_without_the_word(enter: Enter, server: LabServer, present: Callable[[], WireTab], path: str) -> None:
    present()
    stranger = enter(path=path, word="" if "follow" not in path else "another-word-of-a-stranger")
    stranger.until(lambda: card(stranger), "the follower's card")
    assert "data-to=" not in "".join(str(w["props"].get("content")) for w in stranger.widgets.values()), "no button of a presenter"
    assert len(server.sessions) == 1


def test_the_presenters_link_is_exchanged_for_a_cookie_of_its_own(server: LabServer, folder: Path) -> None:
    class Stay(HTTPRedirectHandler):
        def redirect_request(self, *_: object) -> None:
            return None
    word = RoomStore(folder).secret
    with pytest.raises(HTTPError) as answer:
        build_opener(Stay).open(Request(f"{server.url}/?present={word}"), timeout=10)
    assert answer.value.code == 303 and word not in answer.value.headers["Location"]
    cookie = answer.value.headers["Set-Cookie"]
    assert cookie.startswith("observer-lab-0-present=") and "HttpOnly" in cookie and "SameSite=Strict" in cookie


def test_a_copy_of_ones_own_begins_at_the_same_state_and_leaves_the_lecture_alone(enter: Enter, present: Callable[[], WireTab],
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


def test_votes_count_once_are_hidden_below_five_and_light_the_right_option_at_the_end(enter: Enter, present: Callable[[], WireTab],
                                                                                      folder: Path) -> None:
    presenter, follower = present(), enter()
    ask(presenter, "vote:open")
    vote = number_of_the_vote(follower)
    for k in range(HIDDEN_BELOW - 1):
        say(follower, f"vote:{vote}:0:ballot{k:04d}")
    follower.until(lambda: len(follower.notes) == HIDDEN_BELOW - 1, "every acknowledgement")
    presenter.until(lambda: "fewer than 5 votes" in part(presenter, '<section class="ol-room"'), "a vote that is counted")
    assert "ol-bar" not in part(presenter, '<section class="ol-room"')
    say(follower, f"vote:{vote}:1:ballot0000")  # the same browser, another answer
    say(follower, f"vote:{vote}:1:ballot0009")
    presenter.until(lambda: "5 votes" in (room := part(presenter, '<section class="ol-room"')) and "ol-bar" in room, "the counts")
    assert "ol-right" not in card(presenter) + card(follower) and "ol-bar" not in card(follower)
    assert RoomStore(folder).votes()[-1].counts == (3, 2, 0)
    ask(presenter, "vote:close")
    follower.until(lambda: "ol-right" in card(follower), "the right option")
    follower.until(lambda: "ol-bar" in part(follower, '<div class="ol-answer"'), "the histogram")
    say(follower, f"vote:{vote}:1:ballot0010")
    follower.until(lambda: "closed" in follower.notes[-1], "that it is too late")
    assert RoomStore(folder).votes()[-1].counts == (3, 2, 0)
    ask(presenter, "vote:open")
    again = number_of_the_vote(follower)
    for k in range(HIDDEN_BELOW):
        say(follower, f"vote:{again}:1:another{k}")
    follower.until(lambda: sum("is counted" in note for note in follower.notes) == 2 * HIDDEN_BELOW + 1, "the second round")
    ask(presenter, "vote:close")
    follower.until(lambda: part(follower, '<div class="ol-answer"').count("<figure") == 2, "both histograms")


def test_the_presenter_sees_how_many_are_here_where_what_they_fail_at_and_raised_hands(enter: Enter, present: Callable[[], WireTab],
                                                                                       server: LabServer) -> None:
    presenter, follower, own = present(), enter(), enter(path="/?own=1")
    follower.until(lambda: card(follower), "the card")
    own.settle()
    say(follower, "slower")

    def seen() -> str:
        return part(presenter, '<section class="ol-room"')
    presenter.until(lambda: "2 here · following: 1" in seen() and "slower, please: 1" in seen(), "the counts")
    assert LESSONS["separation"].words["en"].title in seen()
    server.sessions[max(server.sessions)].post(CheckNextTask())
    presenter.until(lambda: "tried without success by 1" in seen(), "the task that was not solved")
    ask(presenter, "hands")
    presenter.until(lambda: "slower, please" not in seen(), "lowered hands")


def test_who_comes_later_gets_the_whole_page_and_who_comes_first_waits(tmp_path: Path) -> None:
    server = opened(tmp_path)
    try:
        with WireTab(server.url) as early:
            early.until(lambda: part(early, '<h2 class="ol-scene">'), "that the lecture has not begun")
            with WireTab(server.url, word=RoomStore(tmp_path).secret) as presenter:
                presenter.settle()
                early.until(lambda: card(early), "the card")
                with WireTab(server.url) as late:
                    late.until(lambda: card(late) == card(early) and set(late.nodes) == set(early.nodes), "the same card and scene")
    finally:
        server.stop()


def test_a_restart_brings_back_lecture_and_votes(place: Place) -> None:
    server, secret = opened(place), open_room(place).secret
    with WireTab(server.url, word=secret) as presenter, WireTab(server.url) as follower:
        presenter.settle()
        ask(presenter, f"scene:{PREDICT}")
        ask(presenter, "vote:open")
        vote = number_of_the_vote(follower)
        say(follower, f"vote:{vote}:2:ballot0001")
        follower.until(lambda: follower.notes, "the acknowledgement")
        follower.until(lambda: open_room(place).state, "the kept state")
    server.stop()
    server = opened(place)
    try:
        with WireTab(server.url) as follower:
            follower.until(lambda: 'data-scene="predict"' in card(follower), "the scene of the lecture, before its presenter is back")
            assert open_room(place).votes()[-1].counts == (0, 0, 1) and open_room(place).votes()[-1].open
            with WireTab(server.url, word=secret) as presenter:
                presenter.settle()
                presenter.until(lambda: 'data-scene="predict"' in card(presenter), "the presenter's scene")
    finally:
        server.stop()


def test_another_worker_serves_the_same_page(place: Place) -> None:
    first, second = opened(place, 0), opened(place, 1)
    try:
        with WireTab(first.url, word=open_room(place).secret) as presenter, WireTab(second.url) as follower:
            presenter.settle()
            follower.until(lambda: card(follower), "the page from the other worker")
            ask(presenter, f"scene:{PREDICT}")
            follower.until(lambda: 'data-scene="predict"' in card(follower), "the presenter's scene")
            presenter.until(lambda: "1 here" in part(presenter, '<section class="ol-room"'), "the follower of the other worker")
            assert not second.sessions
    finally:
        first.stop()
        second.stop()


def test_a_typed_question_is_answered_by_options_or_a_number(enter: Enter, present: Callable[[], WireTab]) -> None:
    presenter, follower = present(), enter()
    follower.until(lambda: card(follower), "the card")

    def typed(tab: WireTab) -> str:
        return part(tab, '<section class="ol-typed"')

    def room() -> str:
        return part(presenter, '<section class="ol-room"')
    ask(presenter, "ask:Which <b>gain</b>?\nK\nL\n")
    follower.until(lambda: typed(follower).count('data-room="vote:') == 2, "two options")
    assert "&lt;b&gt;gain" in typed(follower) and "<b>gain" not in typed(follower), "what is typed is no HTML"
    ask(presenter, "ask:How large is it?")
    follower.until(lambda: 'data-room="number:' in typed(follower), "the field for a number")
    found = re.search(r'data-room="number:(\d+)"', typed(follower))
    assert found is not None
    for k in range(6):
        say(follower, f"number:{found[1]}:{0.5 + k / 10}:ballot{k:04d}")
    for odd in ("nan", "inf", "1e99999", "0x10", "", "1_000", "9" * 40):
        say(follower, f"number:{found[1]}:{odd}:ballot9999")
    follower.until(lambda: sum("is counted" in note for note in follower.notes) == 6, "six numbers")
    presenter.until(lambda: "6 votes" in room() and "ol-bar" in room(), "the histogram")
    before = card(presenter)
    ask(presenter, "vote:close")
    follower.until(lambda: "ol-bar" in typed(follower), "the histogram for all")
    assert card(presenter) == before and "ol-right" not in card(follower), "closing it answers no question of the scene"
    ask(presenter, "vote:typed")
    follower.until(lambda: 'data-room="number:' in typed(follower), "the same question again")
    ask(presenter, "ask:only\none")
    presenter.until(lambda: any("two to 8 short options" in note for note in presenter.notes), "what to type")
    ask(presenter, "vote:close")


def test_a_class_places_poles_in_the_lab_and_the_board_shows_their_cloud(enter: Enter, present: Callable[[], WireTab],
                                                                         server: LabServer, folder: Path) -> None:
    presenter, follower = present(), enter()
    follower.until(lambda: card(follower), "the card")
    ask(presenter, "mode:lab")
    presenter.until(lambda: "ol-part-knobs" in str(presenter.widgets), "the lab")
    presenter.settle()  # the head of the lab is there, and the guide's is gone

    def plane() -> str:
        return part(follower, '<section class="ol-typed"')

    def room() -> str:
        return part(presenter, '<section class="ol-room"')

    def open_pole_vote(words: str) -> str:
        ask(presenter, words)
        follower.until(lambda: 'data-room="pole:' in plane(), "the plane")
        found = re.search(r'data-room="pole:(\d+)"', plane())
        assert found is not None
        return found[1]
    vote = open_pole_vote("pole:Where <i>now</i>?")
    assert "Where &lt;i&gt;now" in plane() and "eig(A" in plane(), "the question, and the title of the board"
    for odd in ("nan:0", "0:inf", "1e99:0", "-999:0", "-1:99", "-1", "-1:0:0", "1_0:0", "-1:0j"):
        say(follower, f"pole:{vote}:{odd}:ballot9999")
    say(follower, f"vote:{vote}:0:ballot9998")
    say(follower, f"number:{vote}:-1:ballot9997")
    for k in range(HIDDEN_BELOW - 1):
        say(follower, f"pole:{vote}:-4:{(-1) ** k * 2}:ballot{k:04d}")
    follower.until(lambda: sum("−4 ± 2j is counted" in note for note in follower.notes) == HIDDEN_BELOW - 1, "four poles")
    presenter.until(lambda: "fewer than 5 votes" in room(), "the count")
    assert "<circle" not in room() and not [name for name in presenter.nodes if name.endswith("/placed")]
    say(follower, f"pole:{vote}:-3:0:ballot0009")
    presenter.until(lambda: "5 votes" in room() and room().count("<circle") == 3, "the cloud")
    presenter.until(lambda: "/board/controller/placed" in presenter.nodes, "the cloud on the board")
    assert "<circle" not in plane() and not [name for name in follower.nodes if name.endswith("/placed")], "nothing before the end"
    ask(presenter, "vote:close")
    follower.until(lambda: plane().count("<circle") == 3 and "/board/controller/placed" in follower.nodes, "the cloud for all")
    again = open_pole_vote("vote:typed")
    for k in range(HIDDEN_BELOW):
        say(follower, f"pole:{again}:-6:0:another{k}")
    presenter.until(lambda: room().count("<figure") == 2 and room().count("<circle") == 4, "both clouds side by side")
    assert [dict(each.cloud) for each in RoomStore(folder).votes()[-2:]] == [{-4 + 2j: 4, -3 + 0j: 1}, {-6 + 0j: 5}]
    ask(presenter, "vote:close")
    ask(presenter, "pole:one\nof\nthese")
    presenter.until(lambda: any("has no options" in note for note in presenter.notes), "what to type")
    ask(presenter, "ask:How large?")
    follower.until(lambda: 'data-room="number:' in plane(), "a typed question in the lab")
    ask(presenter, "vote:close")
    server.sessions[max(server.sessions)].post(SetMode("guide"))
    follower.until(lambda: "data-scene=" in card(follower), "the path again")


@pytest.mark.parametrize("said", ["pole:1:nan:0:ballot0001", "pole:1:0:1e999:ballot0001", "pole:1:0:ballot0001", "pole:1:0:0:b",
                                  "pole:x:0:0:ballot0001", "number:1:nan:ballot0001", "number:1::ballot0001",
                                  "number:1:1e999:ballot0001", "", "vote",
                                  "vote:1:0", "vote:1:9:ballot0001", "vote:-1:0:ballot0001", "vote:1:0:b",
                                  "vote:1:0:ballot 001", "vote:1234567890:0:ballot0001", "vote:1:0:ballot0001:more",
                                  "vote:\u0661:0:ballot0001"])
def test_what_is_no_vote_is_not_taken(said: str) -> None:
    assert read_ballot(said) is None


def test_a_follower_reads_the_language_of_its_browser() -> None:
    asked = {"zh-CN,zh;q=0.9": "zh", "de,zh;q=0.5": "zh", "fr": "en", "": "en", "EN-gb": "en"}
    assert {words: preferred_language(words, "en") for words in asked} == asked


def test_a_code_that_no_other_machine_can_open_says_so(enter: Enter) -> None:
    own = enter(path="/?own=1")
    own.settle()
    ask(own, "take")
    own.until(lambda: "Only this computer can open this link" in part(own, '<div class="ol-take"'), "the sentence beside the code")


def test_the_last_presenter_leads_and_the_one_before_leads_again_when_it_leaves(enter: Enter, present: Callable[[], WireTab]) -> None:
    first, follower = present(), enter()
    follower.until(lambda: 'data-scene="predict"' in card(follower), "the first presenter's scene")
    second = present()
    first.until(lambda: any("Another tab now leads" in note for note in first.notes), "that another leads")
    ask(first, "scene:1")
    first.settle()
    ask(second, "scene:2")
    follower.until(lambda: 'data-scene="boards"' in card(follower), "the second presenter's scene")
    assert not any('data-scene="meet"' in str(m.get("updates")) for m in follower.messages)
    second.close()
    follower.until(lambda: 'data-scene="meet"' in card(follower), "the first presenter's scene once more")


def test_of_presenters_at_two_workers_the_last_one_leads_and_followers_come_back_to_it(place: Place) -> None:
    one, other = opened(place, 0), opened(place, 1)
    secret = open_room(place).secret
    try:
        with WireTab(one.url, word=secret) as first, WireTab(one.url) as follower:
            first.settle()
            follower.until(lambda: card(follower), "the card")
            with WireTab(other.url, word=secret) as second:
                second.settle()
                assert follower.closed() == 1012, "its page comes back by itself"
                ask(second, f"scene:{PREDICT}")
                first.until(lambda: any("Another tab now leads" in note for note in first.notes), "that another leads")
                with WireTab(one.url) as back:
                    back.until(lambda: 'data-scene="predict"' in card(back), "the scene of who leads now")
    finally:
        one.stop()
        other.stop()


def test_in_the_lab_followers_see_the_knobs_that_the_presenter_has_moved(enter: Enter, present: Callable[[], WireTab],
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


def test_each_follower_runs_one_seed_and_the_presenter_sees_the_cloud_of_all(place: Place) -> None:
    """On two workers: each follower's page shows one run of its own, and another design takes cloud and runs away."""
    one, other = opened(place, 0, "kalman"), opened(place, 1, "kalman")
    store = open_room(place)
    followers: list[WireTab] = []

    def own(tab: WireTab) -> str:
        return part(tab, '<section class="ol-own-run"')

    def cloud() -> str:
        return part(presenter, '<section class="ol-seeds"')

    def all_see(condition: Callable[[WireTab], object], what: str) -> None:
        for follower in followers:
            follower.until(partial(condition, follower), what)
    try:
        with WireTab(one.url, word=store.secret) as presenter:
            presenter.settle()
            followers += [WireTab((one, other)[k % 2].url) for k in range(5)]
            all_see(card, "the card")
            presenter.until(lambda: len(store.seats()) == 5 and "Run one seed for each follower" in cloud(), "all five numbers")
            ask(presenter, "seeds")
            presenter.until(lambda: "average NEES" in cloud(), "the covariances")
            assert "errors of 5 seeds" in cloud() and cloud().count("<circle") == 5
            all_see(lambda tab: "Your run" in own(tab), "its own run")
            assert len({own(follower) for follower in followers}) == 5, "no two have the same noise"
            seeds = {str(seed) for seed in seeds_of(store.seed, store.seats())}
            sent = "".join(str(m) for tab in (presenter, *followers) for m in tab.messages)
            assert not [seed for seed in {*seeds, str(store.seed)} if seed in sent], "nobody is told a seed"
            say(followers[0], "seeds")
            say(followers[0], "slower")
            followers[0].until(lambda: followers[0].notes, "an answer to the hand")
            assert "average NEES" in cloud() and own(followers[1]), "a follower's press runs nothing"
            ask(presenter, "turn:1")
            all_see(lambda tab: not own(tab), "that the run of another design is gone")
            presenter.until(lambda: "average NEES" not in cloud(), "that the cloud of another design is gone")
            followers.pop().close()
            presenter.until(lambda: len(store.seats()) == 4, "that one has left")
    finally:
        for follower in followers:
            follower.close()
        one.stop()
        other.stop()
