"""Write what a follower reads: the scene's card, its options, and the way to one's own copy."""

from __future__ import annotations

import html
from functools import partial

from ...course.guiding.predictions import prediction_of
from ...course.scenes import Choose, Scene
from ...session.state.view import Picture
from ...text import format_number
from ..guide.scene_card import paragraphs
from ..votes.class_drawings import drawing_html, drawings_html
from ..votes.histogram import question_words, results_html, vote_attributes
from ..votes.pole_plane import placing_html
from ..words import phrases
from ..words.prediction import options_html
from ..words.prose import render_markdown

OWN = "?own=1"  # after which the page of one's own stands


def head_html(picture: Picture) -> str:
    """The lesson's number and title."""
    title = html.escape(picture.lesson.words[picture.state.language].title)
    return f'<div class="ol-head"><span class="ol-lesson">{picture.lesson.number} · {title}</span></div>'


def card_html(picture: Picture) -> str:
    """The scene's title, text and options; in the lab the lesson's question."""
    scene, words = picture.scene, picture.lesson.words[picture.state.language]
    if scene is None:
        return f'<section class="ol-card"><h1 class="ol-scene">{html.escape(words.question)}</h1></section>'
    at, said = picture.lesson.path.index(scene) + 1, picture.scene_words
    parts = [f'<div class="ol-where"><span>{at}/{len(picture.lesson.path)}</span></div>',
             f'<h1 class="ol-scene">{html.escape(said.title)}</h1>'
             f'<div class="ol-text">{paragraphs(picture, said.text, picture.asked)}</div>']
    if isinstance(scene.do, Choose):
        parts.append(_options(picture, scene))
    return f'<section class="ol-card" data-scene="{scene.id}">{"".join(parts)}</section>'


def _options(picture: Picture, scene: Scene) -> str:
    """The options, which can be pressed while the vote is open; the right one is lit once its action is done."""
    asked, open_now = prediction_of(picture.lesson, scene, picture.state.language), picture.voting
    lit = asked.answer if scene.id in picture.state.done and not picture.undecided else None
    press = vote_attributes(picture.votes[-1].number) if open_now else None
    buttons = options_html([render_markdown(words) for words in asked.options], press, lambda k: " ol-right" if k == lit else "")
    lead = f'<p class="ol-todo">{html.escape(phrases.VOTE_NOW(picture.state.language))}</p>' if open_now else ""
    return f'{lead}<div class="ol-choice">{buttons}</div>'


def typed_html(picture: Picture) -> str:
    """The question that the presenter typed: options or a number field while it is open, histograms afterwards."""
    if not picture.typed:
        return ""
    vote, lang = picture.typed[-1], picture.state.language
    assert vote.asked is not None
    head = f'<h3 class="ol-asked">{html.escape(question_words(vote.asked, lang))}</h3>'
    if not vote.open:
        return f'<section class="ol-typed">{head}{results_html(picture.typed, lang, partial(drawings_html, picture))}</section>'
    if (grid := vote.asked.grid) is not None:
        body = placing_html(vote, grid, next((board.title for board in picture.boards if board.id == grid.board), None), lang)
    elif vote.kind == "sketch":
        body = drawing_html(picture, vote)
    elif vote.kind == "number":
        name, send = html.escape(phrases.YOUR_NUMBER(lang), quote=True), html.escape(phrases.SEND(lang))
        body = (f'<p class="ol-number"><input type="number" step="any" aria-label="{name}" placeholder="{name}">'
                f'<button type="button" class="ol-do" data-room="number:{vote.number}">{send}</button></p>')
    else:
        body = options_html([html.escape(option) for option in vote.asked.options], vote_attributes(vote.number))
    return f'<section class="ol-typed">{head}{body}</section>'


def answer_html(picture: Picture) -> str:
    """How the class has voted once the vote is closed, and what is said once the scene is done."""
    scene = picture.scene
    if scene is None:
        return ""
    said = ""
    if not picture.voting:
        said += results_html(picture.votes, picture.state.language)
        if scene.id in picture.state.done and not picture.undecided and picture.scene_words.say:
            said += f'<div class="ol-say">{paragraphs(picture, picture.scene_words.say, picture.kept)}</div>'
    return f'<div class="ol-answer" role="status" aria-live="polite">{said}</div>'


def knobs_html(picture: Picture) -> str:
    """The scene's knobs with their values, or in the lab those that differ from the default."""
    lesson, lang, start = picture.lesson, picture.state.language, picture.lesson.start()
    names = picture.scene.knobs if picture.scene is not None else [
        knob.name for knob in lesson.knobs if not knob.hidden and picture.design[knob.name] != start[knob.name]]
    rows = []
    for name in names:
        knob, value = lesson.knob(name), picture.design[name]
        words = format_number(value, ".4g", lang) if isinstance(value, float) else knob.show(value)
        unit = f" {html.escape(knob.unit)}" if knob.unit else ""
        rows.append(f"<dt>{html.escape(knob.label(lang))}</dt><dd>{html.escape(words)}{unit}</dd>")
    return f'<dl class="ol-knobs">{"".join(rows)}</dl>' if rows else ""


def way_html(token: str, language: str) -> str:
    """The link to one's own copy of what is shown, and the button that asks for a slower lecture."""
    return (f'<div class="ol-way"><a class="ol-do" href="{OWN}#{token}">{html.escape(phrases.TRY_YOURSELF(language))}</a>'
            f'<button type="button" class="ol-do" data-room="slower">{html.escape(phrases.SLOWER_PLEASE(language))}</button></div>')
