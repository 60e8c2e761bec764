"""Define what all commands of a tab are: frozen records that the table of `handlers` knows."""

from __future__ import annotations

import msgspec


class Command(msgspec.Struct, frozen=True):
    """What a person asks of a tab."""


class Notice(Command, frozen=True):
    """What a browser, the room or a background job says by itself: nobody has asked for anything."""
