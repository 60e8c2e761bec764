"""Describe a vote: its question, its counts, and when they may be shown."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from .answer_grids import PoleGrid, SketchGrid, round_step

DISCUSS_S = 120.0  # s of a discussion between two votes
HIDDEN_BELOW = 5  # votes, below which counts would tell who has chosen what
MAX_OPTIONS = 8  # of a question
LONGEST_QUESTION, LONGEST_OPTION = 300, 120  # characters of a question that is typed on the spot
LARGEST_NUMBER = 1e12  # of an answer
MAX_BINS = 8  # of the histogram of numbers
OUTSIDE = 5.0  # percent of the numbers at each end that may lie beyond the middle bins: one absurd number spreads no histogram
Kind = Literal["choice", "number", "pole", "sketch"]
Answer = complex | tuple[float, ...]  # an option's index, a number, a pole, or the heights of a drawing
LONGEST_BALLOT = 64  # characters of the random number by which a browser replaces its own vote


@dataclass(frozen=True)
class Asked:
    """A question that the presenter asks: options to choose from, a grid to place a pole on, the grid of a drawing, or none of them
    where a number is asked for."""

    question: str
    options: tuple[str, ...] = ()
    grid: PoleGrid | None = None
    sketch: SketchGrid | None = None

    @property
    def kind(self) -> Kind:
        """What the class answers with."""
        if self.sketch is not None:
            return "sketch"
        return "pole" if self.grid is not None else "choice" if self.options else "number"

    @property
    def places(self) -> int:
        """How many counts an answer can go to: options, or cells of the grid; the bins of numbers come with the numbers."""
        grid = self.sketch or self.grid
        return len(self.options) if grid is None else grid.cells


def write_asked(asked: Asked | None) -> str:
    """A question as a store keeps it; "" where the scene's own is asked."""
    if asked is None:
        return ""
    return json.dumps({name: value for name, value in asdict(asked).items() if name != "sketch" or value is not None})


def read_asked(said: Any) -> Asked | None:
    """The question in such words, or in what they stand for."""
    if not said:
        return None
    found = json.loads(said) if isinstance(said, str) else said
    return Asked(found["question"], tuple(found["options"]), None if found["grid"] is None else PoleGrid(**found["grid"]),
                 None if found.get("sketch") is None else SketchGrid(**found["sketch"]))


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
    counts_out: bool = False  # whether the presenter shows the counts
    revealed: bool = False  # whether the answer is told
    talks: int = 0  # how often it was put up for discussion; 0 where the class does not discuss it

    @property
    def visible(self) -> bool:
        """Whether the counts may be seen: never while the vote is open."""
        return self.counts_out and not self.open

    @property
    def kind(self) -> Kind:
        """What the class answers with."""
        return "choice" if self.asked is None else self.asked.kind

    def kept(self, answer: Answer) -> float | None:
        """What is written down of an answer: an option's index, a number, the cell of a pole, or a drawing's number.

        None where it is no answer to this.
        """
        sketch = None if self.asked is None else self.asked.sketch
        if isinstance(answer, tuple) or sketch is not None:
            return sketch.number_of(answer) if isinstance(answer, tuple) and sketch is not None else None
        if self.asked is not None and self.asked.grid is not None:
            return self.asked.grid.cell_of(answer) if isinstance(answer, complex) else None
        if isinstance(answer, complex):
            return None
        fits = abs(answer) <= LARGEST_NUMBER if self.kind == "number" else float(answer).is_integer() and 0 <= answer < len(self.counts)
        return answer if fits else None

    def counting(self, answers: Sequence[float]) -> Vote:
        """The vote with these answers counted, as they were written down."""
        if self.kind == "number":
            edges, counts = histogram(answers)
            return replace(self, edges=edges, counts=counts)
        sketch = None if self.asked is None else self.asked.sketch
        found = Counter(answers) if sketch is None else Counter(cell for answer in answers for cell in sketch.cells_of(answer))
        return replace(self, counts=tuple(found[k] for k in range(len(self.counts))))

    def sealed(self) -> Vote:
        """The vote as the audience may see it: without its counts unless they are shown."""
        return self if self.visible else replace(self, counts=(0,) * len(self.counts))

    @property
    def cloud(self) -> tuple[tuple[complex, int], ...]:
        """The poles that were placed, with how often each; nothing while the counts are hidden."""
        grid = None if self.asked is None else self.asked.grid
        return () if grid is None or self.shown is None else tuple((grid.pole_at(k), count) for k, count in enumerate(self.counts) if count)

    @property
    def total(self) -> int:
        """How many have voted."""
        sketch = None if self.asked is None else self.asked.sketch
        return sum(self.counts) // (1 if sketch is None else sketch.pieces)

    @property
    def shown(self) -> tuple[int, ...] | None:
        """The counts where they are shown; None also where so few have voted that a count would tell who chose what."""
        return self.counts if self.visible and self.total >= HIDDEN_BELOW else None


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
    step = round_step((high - low) / (MAX_BINS - 2) or abs(low) / MAX_BINS or 1.0)
    first = math.floor(low / step)
    count = min(math.floor(high / step) - first + 1, MAX_BINS)
    places = np.clip(np.floor(values / step) - first, 0, count - 1).astype(int)
    counts = np.bincount(places, minlength=count)
    return tuple(float(f"{(first + k) * step:.12g}") for k in range(count + 1)), tuple(int(each) for each in counts)


def read_question(words: str) -> Asked | None:
    """A question on the first line and its options on the others, one or more lines; None where there is none or too much."""
    question, *options = [line.strip() for line in words.strip().splitlines() if line.strip()] or [""]
    fits = 0 < len(question) <= LONGEST_QUESTION and len(options) != 1 and len(options) <= MAX_OPTIONS
    return Asked(question, tuple(options)) if fits and all(len(option) <= LONGEST_OPTION for option in options) else None


def read_pole_question(words: str, grid: PoleGrid) -> Asked | None:
    """A question that a pole answers, which may have no words of its own; None where it has options or is too long."""
    question = words.strip()
    return Asked(question, (), grid) if len(question) <= LONGEST_QUESTION and "\n" not in question else None


def is_ballot(word: object) -> bool:
    """Whether a browser sent something that can serve as the key of its vote."""
    return isinstance(word, str) and 8 <= len(word) <= LONGEST_BALLOT and word.isascii() and word.isalnum()
