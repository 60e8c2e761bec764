"""Show a presenter the class in guide and lab: counts, votes, and the field for a question."""

from __future__ import annotations

from types import MappingProxyType

import viser

from ...session.commands.base import Command
from ...session.commands.room import (
    AskPole,
    AskSketch,
    AskTyped,
    AskTypedAgain,
    CloseVote,
    Discuss,
    EndPause,
    HideCounts,
    LowerHands,
    OpenVote,
    PauseAll,
    Reveal,
    ShowCounts,
)
from ...session.state.view import Picture
from ..viser_private import viser_internals
from ..viser_private.write_once import write_content
from .room_card import ask_html, audience_html, hall_html, room_html

VOTES = MappingProxyType({"close": CloseVote, "typed": AskTypedAgain, "sketch": AskSketch})
STAGES = MappingProxyType({"show": ShowCounts, "hide": HideCounts, "discuss": Discuss, "reveal": Reveal})


def room_command(kind: str, value: str) -> Command | None:
    """What a button of the panel asks for; None where the words are of another part of the page."""
    match kind:
        case "vote":
            step, _, number = value.partition(":")
            return STAGES[step](number) if step in STAGES else VOTES.get(value, OpenVote)()
        case "ask":
            return AskTyped(value)
        case "pole":
            return AskPole(value)
        case "hands":
            return LowerHands()
        case "pause":
            return PauseAll() if value == "on" else EndPause()
    return None


class RoomPanel:
    """What a presenter sees of the class. Nothing where the tab presents to nobody."""

    def __init__(self, client: viser.ClientHandle, picture: Picture, hand: str) -> None:
        """`hand` is the widget for which the buttons answer."""
        self._hand, self._client = hand, client
        self._hall: str | None = None  # what this page shows over the stage, None where that is not known
        self._told: str | None = None  # what the speaker's window shows of the class
        self._room = client.gui.add_html("") if picture.state.room is not None else None
        self._ask = ask_html(hand, picture.state.language) + audience_html(picture)
        if self._room is not None:
            client.gui.add_html(self._ask)
            viser_internals.run_script(client, "ask")

    def show(self, picture: Picture) -> None:
        """The counts as they are now."""
        if self._room is not None:
            room = room_html(picture, self._hand)
            write_content(self._room, room)
            if room != self._told:
                self._told = room
                viser_internals.run_script(self._client, "presenter", room=room, ask=self._ask, hand=self._hand)
            hall = hall_html(picture)
            if hall != self._hall:
                self._hall = hall
                viser_internals.run_script(self._client, "hall", html=hall)
