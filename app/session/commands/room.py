"""List what a presenter asks of the room that follows, and what the room says."""

from __future__ import annotations

from dataclasses import dataclass

from ...classroom.room import RoomView


@dataclass(frozen=True)
class OpenVote:
    """Ask the class the question of the open scene, or ask it again."""


@dataclass(frozen=True)
class AskTyped:
    """Ask the class a question that was typed: its first line, and on each further line an option; without options a number."""

    words: object


@dataclass(frozen=True)
class AskPole:
    """Ask the class to place a pole on the board that is in sight, with a question that was typed or without one."""

    words: object


@dataclass(frozen=True)
class AskTypedAgain:
    """Ask the typed question once more."""


@dataclass(frozen=True)
class CloseVote:
    """Take no more votes; the page then does what the question asks about."""


@dataclass(frozen=True)
class LowerHands:
    """Forget who asked for a slower lecture."""


@dataclass(frozen=True)
class RunSeeds:
    """Run the design on many seeds, one for each follower where a class is here; or cancel that."""


@dataclass(frozen=True)
class RoomChanged:
    """Who is here, where, and how the votes stand; nobody has asked for it."""

    view: RoomView


Lecturing = OpenVote | AskTyped | AskPole | AskTypedAgain | CloseVote | LowerHands | RoomChanged
