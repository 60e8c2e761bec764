"""Attach to a sentence the number that it rests on and the bounds of that number."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ...text import NO_WORDS, Text


@dataclass(frozen=True)
class Claim(Text):
    """A sentence that states a fact about the run: it is said because `value` lies on the right side of `edge`."""

    value: float = math.nan
    edge: float = math.nan

    @property
    def margin(self) -> float:
        """How far the number is from the edge beyond which the sentence would be false."""
        return abs(self.value - self.edge)


def claim(words: Text, value: float, *, below: float | None = None, above: float | None = None, otherwise: Text = NO_WORDS) -> Text:
    """The sentence as a claim if above < value < below, another one or none if not; a value that is no number claims nothing."""
    edge = below if below is not None else above
    if edge is None or not (below is None or value < below) or not (above is None or value > above):
        return otherwise
    return Claim(words.id, words.values, words.context, float(value), float(edge))


def claims_in(words: object) -> Iterator[Text]:
    """Every message of a sentence, itself and those that stand in its places."""
    if isinstance(words, Text) and words.id:
        yield words
        for _, value in words.values:
            yield from claims_in(value)
