"""A presenter pauses every page of the class at all workers, whoever comes meanwhile too, and lets them go on."""

from __future__ import annotations

import re

from client import WireTab
from lecture import PREDICT, ask, card, counts, number_of_the_vote, opened, say

from observer_lab.classroom.kept_room import Place, open_room
from observer_lab.session.commands.commands import ChangeSpeed, Predict
from observer_lab.session.commands.guide import SetMode
from observer_lab.session.handlers.room import PAUSED

KNOB = "stiffness error in the model [%]"


def covered(tab: WireTab) -> str:
    """The sentence that covers a tab's page now."""
    sources = [m["source"] for m in tab.messages if m["type"] == "RunJavascriptMessage" and "// freeze.js" in m["source"]]
    found = re.search(r'"words": "([^"]*)"', sources[-1]) if sources else None
    return "" if found is None else found[1]


def test_all_pages_of_a_class_stand_still_until_the_presenter_lets_them_go_on(place: Place) -> None:
    one, other, store = opened(place, 0), opened(place, 1), open_room(place)
    said, tabs = PAUSED("en"), [WireTab(one.url), WireTab(other.url), WireTab(other.url, path="/?own=1")]
    try:
        with WireTab(one.url, word=store.secret) as presenter:
            presenter.settle()
            ask(presenter, f"scene:{PREDICT}")
            ask(presenter, "vote:open")
            first, second, alone = tabs
            vote = number_of_the_vote(first)
            alone.until(lambda: other.sessions and alone.mark(), "the copy of one's own")
            session = next(iter(other.sessions.values()))
            for edit in (SetMode("lab"), Predict(-1), ChangeSpeed(-3)):  # which starts a run; so slow that it does not end meanwhile
                session.post(edit)
            alone.until(lambda: alone.has(KNOB), "the lab on the copy")
            alone.until(lambda: session.picture is not None and session.picture.state.playing, "a run of one's own")
            ask(presenter, "pause:on")
            for tab in tabs:
                tab.until(lambda tab=tab: covered(tab) == said, "the sentence of the pause")
            presenter.until(lambda: "Go on for all" in counts(presenter), "that the presenter sees the pause")
            say(first, f"vote:{vote}:1:ballot0001")
            say(second, "slower")
            for tab in (first, second):
                tab.until(lambda tab=tab: any(said in note for note in tab.notes), "why nothing is taken")
            before = session.picture
            assert before is not None and not before.state.playing
            alone.update(KNOB, value=12.0)
            alone.until(lambda: any(said in note for note in alone.notes), "why the knob is not taken")
            assert session.picture is not None and session.picture.design == before.design
            assert store.votes()[-1].total == 0 and store.presence()[1] == 0
            tabs += [WireTab(one.url), WireTab(one.url, path="/?own=1")]
            for late in tabs[3:]:
                late.until(lambda late=late: covered(late) == said, "the pause on a page that comes late")
            ask(presenter, f"scene:{PREDICT - 1}")
            first.until(lambda: 'data-scene="predict"' not in card(first), "what the presenter shows meanwhile")
            ask(presenter, "pause:off")
            for tab in tabs:
                tab.until(lambda tab=tab: covered(tab) == "", "that the page goes on")
            alone.until(lambda: session.picture is not None and session.picture.state.playing, "that the run goes on")
            alone.update(KNOB, value=9.0)
            alone.until(lambda: session.picture is not None and session.picture.design["stiffness_error"] == 9.0, "the hand on a knob")
            say(first, f"vote:{vote}:1:ballot0002")
            first.until(lambda: store.votes()[-1].total == 1, "the vote that was still open")
            tabs.append(WireTab(other.url))
            tabs[-1].until(lambda: card(tabs[-1]), "the card on a page that comes after the pause")
            assert covered(tabs[-1]) == ""
    finally:
        for tab in tabs:
            tab.close()
        one.stop()
        other.stop()


def test_a_pause_outlives_the_server_and_its_presenter_can_end_it(place: Place) -> None:
    server, store = opened(place), open_room(place)
    with WireTab(server.url, word=store.secret) as presenter:
        presenter.settle()
        ask(presenter, "pause:on")
        presenter.until(lambda: store.paused, "the pause")
    server.stop()
    server = opened(place)
    try:
        with WireTab(server.url, word=store.secret) as presenter, WireTab(server.url) as follower:
            follower.until(lambda: covered(follower) == PAUSED("en"), "the pause after the restart")
            presenter.until(lambda: "Go on for all" in counts(presenter), "the button that ends it")
            ask(presenter, "pause:off")
            follower.until(lambda: covered(follower) == "", "the end of the pause")
            say(follower, "pause:on")
            say(follower, "slower")
            follower.until(lambda: follower.notes, "an answer to the hand")
            assert not store.paused, "nobody but the presenter pauses"
    finally:
        server.stop()
