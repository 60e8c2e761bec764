"""What presenter and followers of a lecture room do over the wire, and what their pages show."""

from __future__ import annotations

import re
from collections.abc import Callable

from client import WireTab

from observer_lab.classroom.kept_room import Place, open_room
from observer_lab.lessons import LESSONS
from observer_lab.page.access.tokens import PRESENTER_FIELD, AccessToken
from observer_lab.page.room.lecture_room import LectureRoom
from observer_lab.page.screen.server import LabServer

PREDICT = next(k for k, scene in enumerate(LESSONS["separation"].path) if scene.id == "predict")
Enter = Callable[..., WireTab]
Present = Callable[[], WireTab]


def opened(place: Place, worker: int = 0, lesson: str = "separation") -> LabServer:
    """A worker of the room that is kept there."""
    return LabServer(LESSONS, port=0, lesson=lesson, mode="guide", room=LectureRoom(place, worker, "en"),
                     presenter=AccessToken(open_room(place).secret, 0, PRESENTER_FIELD))


# --- what a page shows ---------------------------------------------------------------------------------------------
def part(tab: WireTab, opening: str) -> str:
    """What a tab shows in the element that opens so; empty where it has none."""
    contents = (str(widget["props"].get("content")) for widget in tab.widgets.values())
    return next((content for content in contents if content.startswith(opening)), "")


def card(tab: WireTab) -> str:
    """The card of the scene."""
    return part(tab, '<section class="ol-card"')


def typed(tab: WireTab) -> str:
    """The question that the presenter has typed, as a follower sees it."""
    return part(tab, '<section class="ol-typed"')


def counts(tab: WireTab) -> str:
    """What the presenter sees of the class."""
    return part(tab, '<section class="ol-room"')


def number_of_the_vote(tab: WireTab, kind: str = "vote") -> str:
    """The number of an open vote of a kind, once a follower sees it."""
    tab.until(lambda: f'data-room="{kind}:' in card(tab) + typed(tab), f"an open vote of the kind {kind}")
    found = re.search(rf'data-room="{kind}:(\d+)', card(tab) + typed(tab))
    assert found is not None
    return found[1]


# --- what a person does --------------------------------------------------------------------------------------------
def hand(tab: WireTab) -> str:
    """The widget for which a presenter's buttons answer."""
    found = re.search(r'data-to="([^"]+)"', part(tab, '<div class="ol-head'))
    assert found is not None
    return found[1]


def ask(tab: WireTab, value: str) -> None:
    """Send what a press of a button sends from a presenter's page."""
    tab.send("GuiUpdateMessage", uuid=hand(tab), updates={"value": value})


def say(tab: WireTab, value: str) -> None:
    """Send what a press of a button sends from a follower's page."""
    source = next(m["source"] for m in tab.messages if m["type"] == "RunJavascriptMessage" and "// room.js" in m["source"])
    found = re.search(r'"hand": "([^"]+)"', source)
    assert found is not None
    tab.send("GuiUpdateMessage", uuid=found[1], updates={"value": value})
