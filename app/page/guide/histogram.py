"""Draw the counts of votes as bars, those of two rounds side by side."""

from __future__ import annotations

import html
from collections.abc import Sequence
from itertools import pairwise

from ...classroom.votes import HIDDEN_BELOW, Vote
from ...text import format_number
from ..words import phrases

LETTERS = "ABCDEFGH"


def bars_html(votes: Sequence[Vote], language: str) -> str:
    """A histogram for each vote, from left to right in the order of their rounds."""
    return f'<div class="ol-polls">{"".join(_histogram(vote, language) for vote in votes)}</div>'


def _histogram(vote: Vote, language: str) -> str:
    shares = vote.shares
    told = html.escape((phrases.VOTES.format(count=vote.total) if shares else phrases.FEW_VOTES.format(count=HIDDEN_BELOW))(language))
    names = LETTERS if not vote.numeric else [
        f"{format_number(low, '.6g', language)} – {format_number(high, '.6g', language)}" for low, high in pairwise(vote.edges)]
    rows = "" if shares is None else "".join(
        f'<div class="ol-bar" style="--share:{share:.3f}"><b>{names[k]}</b><i></i><span>{count}</span></div>'
        for k, (share, count) in enumerate(zip(shares, vote.counts, strict=True)))
    name = html.escape(phrases.VOTE_ROUND.format(number=vote.round)(language))
    return f'<figure class="ol-poll" data-vote="{vote.number}"><figcaption>{name} · {told}</figcaption>{rows}</figure>'
