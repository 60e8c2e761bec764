"""List what a presenter asks of the room that follows, and what the room says."""

from __future__ import annotations

from dataclasses import dataclass

from ...classroom.room import RoomView


@dataclass(frozen=True)
class OpenVote:
    """Ask the class the question of the open scene, or ask it again."""


@dataclass(frozen=True)
class CloseVote:
    """Take no more votes; the page then does what the question asks about."""


@dataclass(frozen=True)
class LowerHands:
    """Forget who asked for a slower lecture."""


@dataclass(frozen=True)
class RoomChanged:
    """Who is here, where, and how the votes stand; nobody has asked for it."""

    view: RoomView


Lecturing = OpenVote | CloseVote | LowerHands | RoomChanged
