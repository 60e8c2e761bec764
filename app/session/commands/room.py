"""List what a presenter asks of the room that follows, and what the room says."""

from __future__ import annotations

from ...classroom.room import RoomView
from .commands import Command, Notice


class OpenVote(Command, frozen=True):
    """Ask the class the question of the open scene, or ask it again."""


class AskTyped(Command, frozen=True):
    """Ask the class a question that was typed: its first line, and on each further line an option; without options a number."""

    words: object


class AskPole(Command, frozen=True):
    """Ask the class to place a pole on the board that is in sight, with a question that was typed or without one."""

    words: object


class AskSketch(Command, frozen=True):
    """Ask the class to draw its prediction into the figure of the scene's question."""


class AskTypedAgain(Command, frozen=True):
    """Ask the typed question once more."""


class CloseVote(Command, frozen=True):
    """Take no more votes; nothing tells the answer yet."""


class ShowCounts(Command, frozen=True):
    """Show the counts of a closed vote to everybody."""

    number: object


class HideCounts(Command, frozen=True):
    """Hide the counts of a closed vote."""

    number: object


class Discuss(Command, frozen=True):
    """Let the class discuss a closed vote for a while."""

    number: object


class Reveal(Command, frozen=True):
    """Tell the answer to a closed vote; the page then does what the question asks about."""

    number: object


class PerformAnswer(Command, frozen=True):
    """Do what the open scene's question asks about: its answer was told on another page of the presenter."""


class LowerHands(Command, frozen=True):
    """Forget who asked for a slower lecture."""


class PauseAll(Command, frozen=True):
    """Pause the pages of the class: no hand and no run moves anything there."""


class EndPause(Command, frozen=True):
    """Let the pages of the class go on."""


class RunSeeds(Command, frozen=True):
    """Run the design on many seeds, one for each follower where a class is here; or cancel that."""


class RoomChanged(Notice, frozen=True):
    """Who is here, where, and how the votes stand; nobody has asked for it."""

    view: RoomView


class Freeze(Notice, frozen=True):
    """The presenter has paused the pages of the class, or lets them go on."""

    on: bool


class LeadShown(Notice, frozen=True):
    """The state that the leading page of the same presenter shows now that it rests, as a token."""

    token: str
