"""Show a presenter the class in guide and lab: counts, votes, and the field for a question."""

from __future__ import annotations

from types import MappingProxyType

import viser

from ...session.commands.room import AskPole, AskTyped, AskTypedAgain, CloseVote, Lecturing, LowerHands, OpenVote
from ...session.state.view import Picture
from ..viser_private import viser_internals
from ..viser_private.write_once import write_content
from .room_card import ask_html, audience_html, room_html

VOTES = MappingProxyType({"close": CloseVote, "typed": AskTypedAgain})


def room_command(kind: str, value: str) -> Lecturing | None:
    """What a button of the panel asks for; None where the words are of another part of the page."""
    match kind:
        case "vote":
            return VOTES.get(value, OpenVote)()
        case "ask":
            return AskTyped(value)
        case "pole":
            return AskPole(value)
        case "hands":
            return LowerHands()
    return None


class RoomPanel:
    """What a presenter sees of the class. Nothing where the tab presents to nobody."""

    def __init__(self, client: viser.ClientHandle, picture: Picture, hand: str) -> None:
        """`hand` is the widget for which the buttons answer."""
        self._hand = hand
        self._room = client.gui.add_html("") if picture.state.room is not None else None
        if self._room is not None:
            client.gui.add_html(ask_html(hand, picture.state.language) + audience_html(picture))
            viser_internals.run_script(client, "ask")

    def show(self, picture: Picture) -> None:
        """The counts as they are now."""
        if self._room is not None:
            write_content(self._room, room_html(picture, self._hand))
