"""Define gauges: one number a row beside the band in which it is accepted."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...text import NO_WORDS, Text
from .figure_record import WordTable

MIDDLE = (0.36, 0.64)  # of a track: a band with two ends
UPPER = (0.36, 1.0)  # and one with a lower end alone
LOWER = (0.0, 0.64)  # and one with an upper end alone


@dataclass(frozen=True)
class Gauge:
    """A number on a track from 0 to 1: where it is, the `band`, words for it, for the ends of the band and for the verdict.

    A place below 0 or above 1 lies beyond the track; none has no needle. The role is "right", "wrong", or "muted" where nothing is judged.
    """

    name: Text
    at: float | None
    band: tuple[float, float]
    value: Text | str
    ends: tuple[str, str]
    accepted: Text | str
    verdict: Text
    role: str = "right"


@dataclass(frozen=True, eq=False)
class GaugeFigure(WordTable):
    """Numbers of different scales, each on a track of its own; `heads` name the columns of their table."""

    id: str
    title: Text
    gauges: tuple[Gauge, ...]
    heads: tuple[Text, Text, Text, Text]
    caption: Text = NO_WORDS
    tab: Text = NO_WORDS

    @property
    def kind(self) -> str:
        return "gauges"

    @property
    def columns(self) -> tuple[Text, ...]:
        """The heads of its table."""
        return self.heads

    @property
    def rows(self) -> tuple[tuple[Text | str, ...], ...]:
        """The rows of its table."""
        return tuple((each.name, each.value, each.accepted, each.verdict) for each in self.gauges)

    def cells(self) -> tuple[tuple[Text, ...], tuple[tuple[Text | str, ...], ...]]:
        return self.columns, self.rows


def place_of(value: float, low: float, high: float, band: tuple[float, float] = MIDDLE) -> float:
    """The place of a positive number on a logarithmic track with a band from `low` to `high`."""
    if not value > 0 or not 0 < low < high:
        return -1.0
    share = math.log(value / low) / math.log(high / low)
    return band[0] + (band[1] - band[0]) * share if math.isfinite(share) else 2.0
