"""A class places poles in the lab: the presenter sees their cloud, the class sees it at the end."""

from __future__ import annotations

from pathlib import Path

from lecture import Enter, Present, ask, card, counts, number_of_the_vote, say, typed

from observer_lab.classroom.room_store import RoomStore
from observer_lab.classroom.votes import HIDDEN_BELOW
from observer_lab.page.screen.server import LabServer
from observer_lab.session.commands.guide import SetMode


def test_a_class_places_poles_in_the_lab_and_the_board_shows_their_cloud(enter: Enter, present: Present,
                                                                         server: LabServer, tmp_path: Path) -> None:
    presenter, follower = present(), enter()
    follower.until(lambda: card(follower), "the card")
    ask(presenter, "mode:lab")
    presenter.until(lambda: "ol-part-knobs" in str(presenter.widgets), "the lab")
    presenter.settle()  # the head of the lab is there, and the guide's is gone
    ask(presenter, "pole:Where <i>now</i>?")
    vote = number_of_the_vote(follower, "pole")
    assert "Where &lt;i&gt;now" in typed(follower) and "eig(A" in typed(follower), "the question, and the title of the board"
    for odd in ("nan:0", "0:inf", "1e99:0", "-999:0", "-1:99", "-1", "-1:0:0", "1_0:0", "-1:0j"):
        say(follower, f"pole:{vote}:{odd}:ballot9999")
    say(follower, f"vote:{vote}:0:ballot9998")
    say(follower, f"number:{vote}:-1:ballot9997")
    for k in range(HIDDEN_BELOW - 1):
        say(follower, f"pole:{vote}:-4:{(-1) ** k * 2}:ballot{k:04d}")
    follower.until(lambda: sum("−4 ± 2j is counted" in note for note in follower.notes) == HIDDEN_BELOW - 1, "four poles")
    presenter.until(lambda: "4 votes" in counts(presenter), "the count")
    assert "<circle" not in counts(presenter) and not [name for name in presenter.nodes if name.endswith("/placed")]
    say(follower, f"pole:{vote}:-3:0:ballot0009")
    presenter.until(lambda: "5 votes" in counts(presenter), "the count")
    ask(presenter, "vote:close")
    presenter.until(lambda: f"vote:show:{vote}" in counts(presenter), "the end of the vote")
    assert "<circle" not in typed(follower) + counts(presenter), "nothing before the presenter shows it"
    assert not [name for tab in (presenter, follower) for name in tab.nodes if name.endswith("/placed")]
    ask(presenter, f"vote:show:{vote}")
    presenter.until(lambda: counts(presenter).count("<circle") == 3, "the cloud")
    presenter.until(lambda: "/board/controller/placed" in presenter.nodes, "the cloud on the board")
    follower.until(lambda: typed(follower).count("<circle") == 3 and "/board/controller/placed" in follower.nodes, "the cloud for all")
    ask(presenter, "vote:typed")
    again = number_of_the_vote(follower, "pole")
    for k in range(HIDDEN_BELOW):
        say(follower, f"pole:{again}:-6:0:another{k}")
    follower.until(lambda: sum("−6 is counted" in note for note in follower.notes) == HIDDEN_BELOW, "five poles of the second round")
    presenter.until(lambda: "5 votes" in counts(presenter).rpartition("<figure")[2], "the count of the second round")
    ask(presenter, "vote:close")
    presenter.until(lambda: f"vote:show:{again}" in counts(presenter), "the end of the vote")
    ask(presenter, f"vote:show:{again}")
    presenter.until(lambda: counts(presenter).count("<figure") == 2 and counts(presenter).count("<circle") == 4, "both clouds side by side")
    assert [dict(each.cloud) for each in RoomStore(tmp_path).votes()[-2:]] == [{-4 + 2j: 4, -3 + 0j: 1}, {-6 + 0j: 5}]
    ask(presenter, "vote:close")
    ask(presenter, "pole:one\nof\nthese")
    presenter.until(lambda: any("has no options" in note for note in presenter.notes), "what to type")
    ask(presenter, "ask:How large?")
    number_of_the_vote(follower, "number")
    ask(presenter, "vote:close")
    server.sessions[max(server.sessions)].post(SetMode("guide"))
    follower.until(lambda: "data-scene=" in card(follower), "the path again")
