"""Write the section of many seeds: its button, its progress, the cloud of errors and the covariances."""

from __future__ import annotations

import html

from ...course.many_seeds import SEED_COUNT, cloud_figure, covariance_table, verdict_words
from ...session.state.view import Picture
from ..words import phrases
from ..words.prose import with_minus
from .svg import draw

RUN_SEEDS = "seeds"  # what the button asks for


def seeds_html(picture: Picture, hand: str) -> str:
    """The section; nothing in a lesson that runs no seeds, nor where figures wait for a prediction."""
    if picture.lesson.seeds is None or picture.veiled:
        return ""
    many, lang, room = picture.many, picture.state.language, picture.state.room
    follows = room is not None and room.following > 0
    runs = many is not None and many.fraction is not None
    words = phrases.CANCEL_JOB if runs else phrases.SEED_EACH if follows else phrases.SEEDS_ALONE.format(count=SEED_COUNT)
    parts = [f'<button type="button" class="ol-do" data-to="{hand}" data-value="{RUN_SEEDS}">{html.escape(words(lang))}</button>']
    if many is None:
        parts.append(f'<p class="ol-note">{html.escape(phrases.SEEDS_TOLD(lang))}</p>')
    elif runs:
        name = html.escape(phrases.SEEDS_RUN(lang), quote=True)
        parts.append(f'<progress max="1" value="{many.fraction or 0.0:.3f}" aria-label="{name}"></progress>')
    if many is not None and many.found is not None and many.found.count:
        found = many.found
        cloud = cloud_figure(found)
        parts.append(draw(cloud, lang, picture.state.lecture) + f'<p class="ol-caption">{with_minus(cloud.caption(lang))}</p>')
        if many.fraction is None:
            whose = phrases.SEEDS_OF_CLASS if many.followers else phrases.SEEDS_OF_NOBODY
            lost = len(found.kept) - found.count
            given_up = f" {html.escape(phrases.SEEDS_LOST.format(count=lost)(lang))}" if lost else ""
            parts.append(draw(covariance_table(found), lang) + f'<p class="ol-note ol-verdict">{html.escape(verdict_words(found)(lang))} '
                         f"{html.escape(whose(lang))}{given_up}</p>")
    return f'<section class="ol-seeds" role="group">{"".join(parts)}</section>'
