"""Votes in a room: each counts once, few are hidden, a question may be typed, and what is no vote is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from client import WireTab
from lecture import Enter, Present, ask, card, counts, number_of_the_vote, part, say, typed

from observer_lab.classroom.room_store import RoomStore
from observer_lab.classroom.votes import HIDDEN_BELOW
from observer_lab.page.room.follower import read_ballot
from observer_lab.page.screen.server import LabServer


def test_votes_count_once_are_hidden_below_five_and_light_the_right_option_at_the_end(enter: Enter, present: Present,
                                                                                      tmp_path: Path, server: LabServer) -> None:
    presenter, follower = present(), enter()
    ask(presenter, "vote:open")
    vote = number_of_the_vote(follower)
    for k in range(HIDDEN_BELOW - 1):
        say(follower, f"vote:{vote}:0:ballot{k:04d}")
    follower.until(lambda: len(follower.notes) == HIDDEN_BELOW - 1, "every acknowledgement")
    presenter.until(lambda: "4 votes" in counts(presenter), "a vote that is counted")
    assert "ol-bar" not in counts(presenter)
    say(follower, f"vote:{vote}:1:ballot0000")  # the same browser, another answer
    say(follower, f"vote:{vote}:1:ballot0009")
    presenter.until(lambda: "5 votes" in counts(presenter), "the counts")
    assert "ol-right" not in card(presenter) + card(follower) and "ol-bar" not in card(follower) + counts(presenter)
    assert RoomStore(tmp_path).votes()[-1].counts == (3, 2, 0)
    ask(presenter, "vote:close")
    presenter.until(lambda: "5 votes, counts hidden" in counts(presenter), "the end of the vote")
    follower.until(lambda: "data-room" not in card(follower), "the end of the vote")
    ask(presenter, f"vote:show:{vote}")
    follower.until(lambda: "ol-bar" in part(follower, '<div class="ol-answer"'), "the histogram")
    ask(presenter, f"vote:discuss:{vote}")
    follower.until(lambda: "data-talk" in part(follower, '<div class="ol-answer"'), "the time to discuss")
    assert not told(server, presenter, follower), "nothing tells the answer, and nothing is performed"
    say(follower, f"vote:{vote}:1:ballot0010")
    follower.until(lambda: "closed" in follower.notes[-1], "that it is too late")
    assert RoomStore(tmp_path).votes()[-1].counts == (3, 2, 0)
    ask(presenter, f"vote:hide:{vote}")
    follower.until(lambda: "ol-bar" not in part(follower, '<div class="ol-answer"'), "hidden counts")
    ask(presenter, "vote:open")
    again = number_of_the_vote(follower)
    for k in range(HIDDEN_BELOW):
        say(follower, f"vote:{again}:1:another{k}")
    follower.until(lambda: sum("is counted" in note for note in follower.notes) == 2 * HIDDEN_BELOW + 1, "the second round")
    ask(presenter, "vote:close")
    presenter.until(lambda: f"vote:reveal:{again}" in counts(presenter), "the button that tells the answer")
    assert not told(server, presenter, follower)
    ask(presenter, f"vote:show:{vote}")
    ask(presenter, f"vote:reveal:{again}")
    follower.until(lambda: "ol-right" in card(follower), "the right option")
    follower.until(lambda: part(follower, '<div class="ol-answer"').count("<figure") == 2, "both histograms")
    presenter.until(lambda: counts(presenter).count("ol-bar") == 6 and "ol-right" in card(presenter), "the same for the presenter")
    ask(presenter, "vote:reveal:99")
    presenter.until(lambda: "There is no closed vote 99." in presenter.notes, "that there is none")


def told(server: LabServer, presenter: WireTab, follower: WireTab) -> bool:
    """Whether a page shows which option is right, or the presenter's page has done what the question asks about."""
    done = any(session.picture is not None and "predict" in session.picture.state.done for session in server.sessions.values())
    return done or "ol-right" in card(presenter) + card(follower) or "ol-say" in part(follower, '<div class="ol-answer"')


def test_with_few_votes_the_page_says_how_many_and_the_answer_can_be_told(enter: Enter, present: Present) -> None:
    presenter, follower = present(), enter()
    ask(presenter, "vote:open")
    vote = number_of_the_vote(follower)
    for k in range(3):
        say(follower, f"vote:{vote}:0:ballot{k:04d}")
    follower.until(lambda: len(follower.notes) == 3, "every acknowledgement")
    ask(presenter, "vote:close")
    presenter.until(lambda: "3 votes. Below 5 no counts are shown" in counts(presenter), "how many, and what will happen")
    ask(presenter, f"vote:reveal:{vote}")
    follower.until(lambda: "ol-right" in card(follower), "the right option")
    assert "ol-bar" not in counts(presenter) + part(follower, '<div class="ol-answer"')


def test_a_typed_question_is_answered_by_options_or_a_number(enter: Enter, present: Present) -> None:
    presenter, follower = present(), enter()
    follower.until(lambda: card(follower), "the card")
    ask(presenter, "ask:Which <b>gain</b>?\nK\nL\n")
    follower.until(lambda: typed(follower).count('data-room="vote:') == 2, "two options")
    assert "&lt;b&gt;gain" in typed(follower) and "<b>gain" not in typed(follower), "what is typed is no HTML"
    ask(presenter, "ask:How large is it?")
    vote = number_of_the_vote(follower, "number")
    for k in range(6):
        say(follower, f"number:{vote}:{0.5 + k / 10}:ballot{k:04d}")
    for odd in ("nan", "inf", "1e99999", "0x10", "", "1_000", "9" * 40):
        say(follower, f"number:{vote}:{odd}:ballot9999")
    follower.until(lambda: sum("is counted" in note for note in follower.notes) == 6, "six numbers")
    presenter.until(lambda: "6 votes" in counts(presenter), "the count")
    before = card(presenter)
    ask(presenter, "vote:close")
    presenter.until(lambda: f"vote:show:{vote}" in counts(presenter), "the end of the vote")
    ask(presenter, f"vote:show:{vote}")
    presenter.until(lambda: "ol-bar" in counts(presenter), "the histogram")
    follower.until(lambda: "ol-bar" in typed(follower), "the histogram for all")
    assert card(presenter) == before and "ol-right" not in card(follower), "closing it answers no question of the scene"
    ask(presenter, "vote:typed")
    assert number_of_the_vote(follower, "number") != vote, "the same question again is another vote"
    ask(presenter, "ask:only\none")
    presenter.until(lambda: any("two to 8 short options" in note for note in presenter.notes), "what to type")
    ask(presenter, "vote:close")


@pytest.mark.parametrize("said", ["pole:1:nan:0:ballot0001", "pole:1:0:1e999:ballot0001", "pole:1:0:ballot0001", "pole:1:0:0:b",
                                  "pole:x:0:0:ballot0001", "number:1:nan:ballot0001", "number:1::ballot0001",
                                  "number:1:1e999:ballot0001", "", "vote",
                                  "vote:1:0", "vote:1:9:ballot0001", "vote:-1:0:ballot0001", "vote:1:0:b",
                                  "vote:1:0:ballot 001", "vote:1234567890:0:ballot0001", "vote:1:0:ballot0001:more",
                                  "vote:\u0661:0:ballot0001"])
def test_what_is_no_vote_is_not_taken(said: str) -> None:
    assert read_ballot(said) is None
