"""Describe a vote: its question, its counts, and when they may be shown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

HIDDEN_BELOW = 5  # votes, below which counts would tell who has chosen what
MAX_OPTIONS = 8  # of a question
LONGEST_QUESTION, LONGEST_OPTION = 300, 120  # characters of a question that is typed on the spot
LARGEST_NUMBER = 1e12  # of an answer
MAX_BINS = 8  # of the histogram of numbers
OUTSIDE = 5.0  # percent of the numbers at each end that may lie beyond the middle bins: one absurd number spreads no histogram
Kind = Literal["choice", "number"]
LONGEST_BALLOT = 64  # characters of the random number by which a browser replaces its own vote


@dataclass(frozen=True)
class Asked:
    """A question that the presenter has typed: options to choose from, or none where a number is asked for."""

    question: str
    options: tuple[str, ...] = ()

    @property
    def kind(self) -> Kind:
        """Whether an option or a number is asked for."""
        return "choice" if self.options else "number"


@dataclass(frozen=True)
class Vote:
    """A vote on the question of a scene, or on what was `asked` there by the presenter.

    `round` is 1 before the explanation and counts up with each time it is asked again.

    `counts` has one number for each option, or for each bin between two `edges`. It does not say which browser sent what.
    """

    number: int
    lesson: str
    scene: str
    round: int
    open: bool
    counts: tuple[int, ...]
    asked: Asked | None = None
    edges: tuple[float, ...] = ()

    @property
    def numeric(self) -> bool:
        """Whether a number is asked for."""
        return self.asked is not None and self.asked.kind == "number"

    def takes(self, answer: float) -> bool:
        """Whether that is an answer to the question: the index of an option, or any number."""
        return abs(answer) <= LARGEST_NUMBER if self.numeric else float(answer).is_integer() and 0 <= answer < len(self.counts)

    def counting(self, answers: Sequence[float]) -> Vote:
        """The vote with these answers counted."""
        if self.numeric:
            edges, counts = histogram(answers)
            return replace(self, edges=edges, counts=counts)
        return replace(self, counts=tuple(sum(answer == k for answer in answers) for k in range(len(self.counts))))

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
    return tuple(sorted((vote for vote in votes if (vote.lesson, vote.scene, vote.asked) == (lesson, scene, None)),
                        key=lambda vote: vote.round))[-2:]


def votes_on_typed(votes: Sequence[Vote], lesson: str, scene: str) -> tuple[Vote, ...]:
    """The votes on the question that was typed last in a scene, likewise."""
    typed = [vote for vote in votes if (vote.lesson, vote.scene) == (lesson, scene) and vote.asked is not None]
    return tuple(sorted((vote for vote in typed if vote.asked == typed[-1].asked), key=lambda vote: vote.round))[-2:]


def histogram(numbers: Sequence[float]) -> tuple[tuple[float, ...], tuple[int, ...]]:
    """Edges on round numbers and the counts between them; what lies far outside is counted in the first or the last bin."""
    if not numbers:
        return (), ()
    values = np.asarray(numbers, dtype=float)
    low, high = (float(end) for end in np.percentile(values, (OUTSIDE, 100 - OUTSIDE)))
    step = _round_step((high - low) / (MAX_BINS - 2) or abs(low) / MAX_BINS or 1.0)
    first = math.floor(low / step)
    count = min(math.floor(high / step) - first + 1, MAX_BINS)
    places = np.clip(np.floor(values / step) - first, 0, count - 1).astype(int)
    counts = np.bincount(places, minlength=count)
    return tuple(float(f"{(first + k) * step:.12g}") for k in range(count + 1)), tuple(int(each) for each in counts)


def _round_step(least: float) -> float:
    """The next of 1, 2, 5 times a power of ten."""
    decade = 10.0 ** math.floor(math.log10(least))
    return next(times * decade for times in (1, 2, 5, 10) if times * decade >= least * (1 - 1e-9))


def read_question(words: str) -> Asked | None:
    """A question on the first line and its options on the others, one or more lines; None where there is none or too much."""
    question, *options = [line.strip() for line in words.strip().splitlines() if line.strip()] or [""]
    fits = 0 < len(question) <= LONGEST_QUESTION and len(options) != 1 and len(options) <= MAX_OPTIONS
    return Asked(question, tuple(options)) if fits and all(len(option) <= LONGEST_OPTION for option in options) else None


def is_ballot(word: object) -> bool:
    """Whether a browser sent something that can serve as the key of its vote."""
    return isinstance(word, str) and 8 <= len(word) <= LONGEST_BALLOT and word.isascii() and word.isalnum()
