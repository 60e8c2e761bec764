"""Draw the counts of votes as bars, placed poles as a cloud; two rounds stand side by side."""

from __future__ import annotations

import html
from collections.abc import Sequence
from itertools import pairwise
from typing import assert_never

from ...classroom.votes import HIDDEN_BELOW, Asked, Kind, Vote, histogram
from ...text import format_number
from ..words import phrases
from .pole_plane import cloud_svg, pole_words

LETTERS = "ABCDEFGH"


def question_words(asked: Asked, language: str) -> str:
    """What the presenter has typed, or the usual question for a pole."""
    return asked.question or phrases.PLACE_POLE(language)


def answer_words(kind: Kind, answer: complex, language: str) -> str:
    """An answer as its sender reads it: an option's letter, a number or a pole."""
    match kind:
        case "choice":
            return LETTERS[int(answer.real)]
        case "number":
            return format_number(answer.real, ".6g", language)
        case "pole":
            return pole_words(answer)
        case _:
            assert_never(kind)


def bars_html(votes: Sequence[Vote], language: str) -> str:
    """A histogram for each vote, from left to right in the order of their rounds."""
    return f'<div class="ol-polls">{"".join(_histogram(vote, language, len(votes)) for vote in votes)}</div>'


def _histogram(vote: Vote, language: str, beside: int) -> str:
    shown = vote.shown
    told = html.escape((phrases.VOTES.format(count=vote.total) if shown else phrases.FEW_VOTES.format(count=HIDDEN_BELOW))(language))
    name = html.escape(phrases.VOTE_ROUND.format(number=vote.round)(language))
    rows = "" if shown is None else _rows(vote, shown, language, beside)
    return f'<figure class="ol-poll" data-vote="{vote.number}"><figcaption>{name} · {told}</figcaption>{rows}</figure>'


def _rows(vote: Vote, counts: Sequence[int], language: str, beside: int) -> str:
    """A bar for each option or bin; of poles the plane with their cloud, and bars over their real parts."""
    if vote.asked is not None and vote.asked.grid is not None:
        edges, counts = histogram([pole.real for pole, count in vote.cloud for _ in range(count)])
        name = html.escape(phrases.REAL_PARTS(language))
        return f'{cloud_svg(vote, vote.asked.grid, language, beside)}<p class="ol-note">{name}</p>{_bars(_bins(edges, language), counts)}'
    return _bars(_bins(vote.edges, language) if vote.kind == "number" else LETTERS, counts)


def _bins(edges: Sequence[float], language: str) -> list[str]:
    return [f"{format_number(low, '.6g', language)} – {format_number(high, '.6g', language)}" for low, high in pairwise(edges)]


def _bars(names: Sequence[str], counts: Sequence[int]) -> str:
    return "".join(f'<div class="ol-bar" style="--share:{count / sum(counts):.3f}"><b>{names[k]}</b><i></i><span>{count}</span></div>'
                   for k, count in enumerate(counts))
