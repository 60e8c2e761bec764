"""Hear one follower: a vote or a raised hand; nothing else that it sends is taken."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import viser

from ...classroom.answer_grids import LONGEST_SKETCH
from ...classroom.votes import MAX_OPTIONS, Answer, Kind, is_ballot
from ...session.handlers.room import PAUSED
from ...text import languages
from ..viser_private import page_scripts, viser_internals
from ..viser_private.hidden_input import hidden_input
from ..votes.histogram import counted_words
from ..words import phrases

ABOVE_ALL = -1e8  # the order of what stands first on a page
NOTICE_S = 4.0  # s that a sentence stands on the page
LONGEST_NUMBER = 9  # digits
DECIMAL = re.compile(r"[+-]?(?:\d{1,15}(?:\.\d{0,15})?|\.\d{1,15})(?:[eE][+-]?\d{1,2})?", re.ASCII)


@dataclass(frozen=True)
class Ballot:
    """A vote as a browser sends it: which one, its random number, and the index of an option, a number, a pole or a drawing."""

    vote: int
    ballot: str
    answer: Answer
    kind: Kind = "choice"


def read_ballot(said: str) -> Ballot | None:
    """The vote in `vote:VOTE:OPTION:BALLOT`, `number:VOTE:NUMBER:BALLOT`, `pole:VOTE:RE:IM:BALLOT` or `sketch:VOTE:SHARE,SHARE:BALLOT`.

    None where that is not one.
    """
    match said.split(":"):
        case ["vote", vote, option, ballot] if is_number(vote) and is_number(option) and is_ballot(ballot):
            return Ballot(int(vote), ballot, int(option)) if int(option) < MAX_OPTIONS else None
        case ["number", vote, number, ballot] if is_number(vote) and is_decimal(number) and is_ballot(ballot):
            return Ballot(int(vote), ballot, float(number), "number")
        case ["pole", vote, re, im, ballot] if is_number(vote) and is_decimal(re) and is_decimal(im) and is_ballot(ballot):
            return Ballot(int(vote), ballot, complex(float(re), float(im)), "pole")
        case ["sketch", vote, heights, ballot] if is_number(vote) and is_ballot(ballot):
            shares = heights.split(",", LONGEST_SKETCH)
            return Ballot(int(vote), ballot, tuple(map(float, shares)), "sketch") if all(map(is_decimal, shares)) else None
    return None


def is_number(word: str) -> bool:
    """Whether these are a few digits."""
    return word.isascii() and word.isdigit() and len(word) <= LONGEST_NUMBER


def is_decimal(word: str) -> bool:
    """Whether this is a number, and a finite one."""
    return DECIMAL.fullmatch(word) is not None


def preferred_language(asked: str, usual: str) -> str:
    """The first language of ours that a browser names in Accept-Language, else the usual one."""
    for part in asked.split(","):
        code = part.partition(";")[0].strip().lower().partition("-")[0]
        if code in languages():
            return code
    return usual


class Ears(Protocol):
    """Who takes what a follower says."""

    def cast(self, ballot: Ballot, told: Callable[[bool], object]) -> None:
        """Take a vote; `told` is called on the event loop once it is written down, with whether it counts."""


class Follower:
    """One browser that follows: where it says what, and whether its hand is raised."""

    def __init__(self, client: viser.ClientHandle, language: str, ears: Ears) -> None:
        self._client, self.language, self._ears = client, language, ears
        self.raised = self.frozen = False
        self._run: viser.GuiHtmlHandle | None = None
        self._hand = viser_internals.node_id(hidden_input(client.gui, self.hear))
        self._waits: viser.GuiHtmlHandle | None = client.gui.add_html(
            f'<h1 class="ol-scene">{phrases.NOT_BEGUN(language)}</h1>')  # until there is a page
        viser_internals.hear_beats(client, self._acknowledge)
        viser_internals.run_script(client, "plane")
        viser_internals.run_script(client, "sketch")
        viser_internals.run_script(client, "room", hand=self._hand)
        client.flush()

    def begin(self) -> None:
        """The shared page comes now."""
        if self._waits is not None:
            self._waits.remove()
            self._waits = None
            self._client.flush()

    def freeze(self, on: bool) -> None:
        """Let the page stand still, with a sentence, or go on."""
        self.frozen = on
        page_scripts.freeze(self._client, PAUSED(self.language) if on else "")
        self._client.flush()

    def show_run(self, content: str) -> None:
        """Show this follower's own run above the shared page; "" takes it away."""
        if self._run is not None:
            self._run.remove()
            self._run = None
        if content:
            self._run = self._client.gui.add_html(content, order=ABOVE_ALL)
        self._client.flush()

    def _acknowledge(self, said: int) -> None:
        """What a follower says is taken as it comes."""
        page_scripts.acknowledge(self._client, said)
        self._client.flush()

    def hear(self, said: str) -> None:
        """A vote or a hand; anything else changes nothing."""
        if self.frozen:
            self._say(PAUSED(self.language))
            return
        if said == "slower":
            self.raised = not self.raised
            if self.raised:
                self._say(phrases.HAND_RAISED(self.language))
            return
        ballot = read_ballot(said)
        if ballot is not None:
            self._ears.cast(ballot, lambda counted: self._tell(ballot, counted))

    def _tell(self, ballot: Ballot, counted: bool) -> None:
        option = int(ballot.answer.real) if ballot.kind == "choice" and not isinstance(ballot.answer, tuple) else -1
        viser_internals.run_script(self._client, "room", vote=ballot.vote, option=option, counted=counted)
        self._say(counted_words(ballot.kind, ballot.answer, self.language) if counted else phrases.VOTE_REFUSED(self.language))

    def _say(self, words: str) -> None:
        self._client.add_notification("Observer Lab", words, auto_close_seconds=NOTICE_S)
        self._client.flush()
