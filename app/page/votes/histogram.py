"""Draw the counts of votes as bars, placed poles as a cloud; two rounds stand side by side."""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import assert_never

from ...classroom.votes import DISCUSS_S, HIDDEN_BELOW, Answer, Asked, Kind, Vote, histogram
from ...course.guiding.predictions import LETTERS
from ...text import format_number
from ..words import phrases
from .pole_plane import cloud_svg, pole_words


def question_words(asked: Asked, language: str) -> str:
    """What the presenter has typed, or the usual question for a pole or a drawing."""
    return asked.question or (phrases.DRAW_WHAT if asked.kind == "sketch" else phrases.PLACE_POLE)(language)


def counted_words(kind: Kind, answer: Answer, language: str) -> str:
    """That an answer is counted, as its sender reads it: an option's letter, a number, a pole or a drawing."""
    if isinstance(answer, tuple):
        return phrases.DRAWING_COUNTED(language)
    return phrases.VOTE_COUNTED.format(letter=_answer_words(kind, answer, language))(language)


def _answer_words(kind: Kind, answer: complex, language: str) -> str:
    assert kind != "sketch", "a drawing is no number"
    match kind:
        case "choice":
            return LETTERS[int(answer.real)]
        case "number":
            return format_number(answer.real, ".6g", language)
        case "pole":
            return pole_words(answer)
        case _:
            assert_never(kind)


def no_drawings(vote: Vote) -> str:
    """Nothing: the class was asked for no drawing."""
    return ""


def vote_attributes(number: int) -> Callable[[int], str]:
    """The attributes of the button that votes for an option."""
    return lambda k: f'data-room="vote:{number}:{k}"'


def bars_html(votes: Sequence[Vote], language: str, drawings: Callable[[Vote], str] = no_drawings) -> str:
    """A histogram for each vote, from left to right in the order of their rounds; where none is shown, how many have voted.

    `drawings` draws a vote in which the class has drawn.
    """
    return f'<div class="ol-polls">{"".join(_histogram(vote, language, len(votes), drawings) for vote in votes)}</div>' if votes else ""


def results_html(votes: Sequence[Vote], language: str, drawings: Callable[[Vote], str] = no_drawings) -> str:
    """The histograms that are shown to everybody, and how long the class discusses; `drawings` as in `bars_html`."""
    return bars_html([vote for vote in votes if vote.visible], language, drawings) + discussion_html(votes, language)


def discussion_html(votes: Sequence[Vote], language: str) -> str:
    """That the class discusses, with the time that is left; the page counts it down."""
    if not votes or votes[-1].open or not votes[-1].talks:
        return ""
    left = f'<b class="ol-countdown" role="timer" data-talk="{votes[-1].number}.{votes[-1].talks}" data-most="{DISCUSS_S:.0f}"></b>'
    return f'<p class="ol-discuss">{html.escape(phrases.DISCUSS_NOW(language))} {left}</p>'


def _told(vote: Vote, language: str) -> str:
    """How many have voted, and what that means for the counts."""
    if not vote.open and vote.total < HIDDEN_BELOW:
        return phrases.FEW_VOTES.format(count=vote.total, least=HIDDEN_BELOW)(language)
    return (phrases.VOTES if vote.open or vote.visible else phrases.HIDDEN_VOTES).format(count=vote.total)(language)


def _histogram(vote: Vote, language: str, beside: int, drawings: Callable[[Vote], str]) -> str:
    shown = vote.shown
    told = html.escape(_told(vote, language))
    name = html.escape(phrases.VOTE_ROUND.format(number=vote.round)(language))
    rows = "" if shown is None else drawings(vote) if vote.kind == "sketch" else _rows(vote, shown, language, beside)
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
