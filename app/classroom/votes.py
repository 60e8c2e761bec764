"""Describe a vote: its question, its counts, and when they may be shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

HIDDEN_BELOW = 5  # votes, below which counts would tell who has chosen what
MAX_OPTIONS = 8  # of a question
LONGEST_BALLOT = 64  # characters of the random number by which a browser replaces its own vote


@dataclass(frozen=True)
class Vote:
    """A vote on the question of a scene. `round` is 1 before the explanation and counts up with each time it is asked again.

    `counts` has one number for each option. It does not say which browser sent what.
    """

    number: int
    lesson: str
    scene: str
    round: int
    open: bool
    counts: tuple[int, ...]

    @property
    def total(self) -> int:
        """How many have voted."""
        return sum(self.counts)

    @property
    def shown(self) -> tuple[int, ...] | None:
        """The counts as they may be shown; None while so few have voted that a count would tell who chose what."""
        return self.counts if self.total >= HIDDEN_BELOW else None

    @property
    def shares(self) -> tuple[float, ...] | None:
        """The part of all votes that each option has, from 0 to 1; None where the counts are hidden."""
        return None if self.shown is None else tuple(count / self.total for count in self.shown)


def votes_on(votes: Sequence[Vote], lesson: str, scene: str) -> tuple[Vote, ...]:
    """The votes on a scene's question in the order of their rounds: the last time it was asked, and the time before that."""
    return tuple(sorted((vote for vote in votes if (vote.lesson, vote.scene) == (lesson, scene)), key=lambda vote: vote.round))[-2:]


def is_ballot(word: object) -> bool:
    """Whether a browser sent something that can serve as the key of its vote."""
    return isinstance(word, str) and 8 <= len(word) <= LONGEST_BALLOT and word.isascii() and word.isalnum()
