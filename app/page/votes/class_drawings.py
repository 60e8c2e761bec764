"""Let a class draw a prediction into a question, and show all drawings there as a cloud."""

from __future__ import annotations

import html

import numpy as np

from ...classroom.answer_grids import LEVELS
from ...classroom.votes import Vote
from ...course.figures.records import PlaneFigure
from ...course.guiding.questions import bar_width
from ...session.state.view import Picture
from ..charts.print_sizes import Sizes
from ..charts.svg import axes_of_plane, draw, sketch_frame
from ..words import phrases

FAINTEST = 0.25  # opacity of what a single hand has drawn


def drawing_html(picture: Picture, vote: Vote) -> str:
    """The figure of the scene's question, into which a follower draws, and the button that sends the drawing."""
    if picture.question is None:
        return ""
    lang, sizes = picture.state.language, Sizes(picture.state)
    figure = picture.question.drawn(None, False)
    send = f'<button type="button" class="ol-do" disabled data-room="sketch:{vote.number}">{html.escape(phrases.SEND(lang))}</button>'
    drawn = draw(figure, lang, sizes.large_words, sizes.question())
    return sketch_frame(picture.question, figure, drawn, sizes.question(), lang, f"vote/{vote.number}", phrases.DRAW_HOW(lang), send)


def drawings_html(picture: Picture, vote: Vote) -> str:
    """The figure with all drawings of a vote that are shown, darker where more agree; the run's too once it was performed."""
    counts, question, scene, lang = vote.shown, picture.question, picture.scene, picture.state.language
    if counts is None or question is None or scene is None:
        return ""
    sizes, answered = Sizes(picture.state), scene.id in picture.state.done and not picture.undecided
    figure = question.drawn(None, answered)
    name = html.escape(f"{phrases.CLASS_DRAWINGS(lang)} {phrases.VOTES.format(count=vote.total)(lang)}", quote=True)
    cloud = f'<g class="ol-drawings" role="img" aria-label="{name}">{_strokes(vote, counts, question.columns, figure, lang, sizes)}</g>'
    drawn, under = draw(figure, lang, sizes.large_words, sizes.question()), f'<g clip-path="url(#clip-{figure.id})">'
    return drawn.replace(under, f"{under}{cloud}", 1)


def _strokes(vote: Vote, counts: tuple[int, ...], columns: tuple[float, ...], figure: PlaneFigure, language: str, sizes: Sizes) -> str:
    """A stroke for each piece that was drawn."""
    assert vote.asked is not None and vote.asked.sketch is not None
    grid, axes = vote.asked.sketch, axes_of_plane(figure, language, sizes.question())
    places = np.interp(np.linspace(0, len(columns) - 1, grid.columns), np.arange(len(columns)), columns)
    low, high = figure.y_range
    most, out, wide = max(counts), [], bar_width(max(len(figure.names), 1))
    for cell, count in enumerate(counts):
        if count:
            ends = [axes.at(float(places[column]), low + level / (LEVELS - 1) * (high - low)) for column, level in grid.places_of(cell)]
            path = " L".join(f"{x:.1f} {y:.1f}" for x, y in ends) if not grid.bars else (
                f"{ends[0][0] - wide / 2:.1f} {ends[0][1]:.1f}h{wide:g}")
            out.append(f'<path d="M{path}" opacity="{FAINTEST + (1 - FAINTEST) * count / most:.2f}"/>')
    return "".join(out)
