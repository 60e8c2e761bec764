"""Write the card of a scene as HTML: its place in the path, text, options, verdict and the way on."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...course.lectures import words_in
from ...course.scenes import Choose, Read, Scene, fill_numbers
from ...session.handlers.guide import options_of
from ...session.state.view import Picture
from ...text import format_number, languages, name_of
from ..words import phrases
from ..words.mode_switch import mode_switch
from ..words.prose import explained_html, formula_html, judged_html, render_markdown, with_minus

LETTERS = "ABCDEFGH"


def live_numbers(picture: Picture, words: str) -> str:
    """Words with the picture's numbers in their places; a dash where one is not known or not finite."""
    numbers: Mapping[str, Any] = {**picture.outcome.metrics}

    def number(name: str, spec: str) -> str:
        value = numbers.get(name)
        if value is None:
            value = dict(picture.design.values).get(name)
        if isinstance(value, (bool, str)) or value is None or not np.isfinite(value):
            return "–"
        return format_number(float(value), spec, picture.state.language)
    return fill_numbers(words, number)


def paragraphs(picture: Picture, words: str) -> str:
    """Text of a scene as HTML: Markdown's emphasis, equations, and the live numbers."""
    text = "".join(f"<p>{_emphasised(render_markdown(with_minus(live_numbers(picture, part))))}</p>"
                   for part in words.split("\n\n") if part.strip())
    return explained_html(picture.lesson.words[picture.state.language], text)


def _emphasised(words: str) -> str:
    parts = words.split("*")
    return words if len(parts) % 2 == 0 else "".join(f"<b>{part}</b>" if k % 2 else part for k, part in enumerate(parts))


def mode_row(picture: Picture, hand: str) -> str:
    """The switch between guide, lab and present, and the button of the page of lessons."""
    lang, now = picture.state.language, picture.state.mode
    theme = phrases.LIGHT if picture.state.is_dark else phrases.DARK_THEME
    talk = picture.state.talk
    items = [("end", phrases.END_LECTURE(lang))] if talk is not None else []
    items += [("record", phrases.RECORD_STOP(lang))]
    if picture.state.recorded:
        items += [("save", phrases.SAVE_LECTURE.format(count=len(picture.state.recorded))(lang))]
    items += [("language", " / ".join(name_of(code) for code in languages())), ("theme", theme(lang)), ("take", phrases.TAKE(lang)),
             ("terms", phrases.GLOSSARY(lang)), ("help", phrases.HELP(lang)), ("reset", phrases.RESET(lang))]
    more = "".join(f'<button type="button" class="ol-item" data-to="{hand}" data-value="{value}">{html.escape(words)}</button>'
                   for value, words in items)
    more += f'<button type="button" class="ol-item ol-search">{html.escape(phrases.SEARCH(lang))}</button>'
    more += f'<button type="button" class="ol-item ol-notes">{html.escape(phrases.NOTES(lang))}</button>'
    title = f"{picture.lesson.number} · {picture.lesson.words[lang].title}"
    whole = title if talk is None else f"{words_in(talk.title, lang)} · {title}"
    hall = " ol-present" if now == "present" else ""
    return (f'<div class="ol-head{hall}"><button type="button" class="ol-menu" data-to="{hand}" data-value="course" '
            f'aria-label="{html.escape(phrases.COURSE(lang), quote=True)}">☰</button>'
            f'<span class="ol-lesson" title="{html.escape(whole, quote=True)}">{html.escape(title)}</span>'
            f"{mode_switch(now, lang, hand)}"
            f'<details class="ol-more"><summary aria-label="{html.escape(phrases.MORE(lang), quote=True)}">⋯</summary>'
            f"<div>{more}</div></details></div>")


def card_html(picture: Picture, hand: str) -> str:
    """The scene's title, text and options, and what is to be done."""
    scene, words = picture.scene, picture.scene_words
    assert scene is not None
    at, count = picture.place
    in_lecture = picture.state.talk is not None
    done = [k < at for k in range(count)] if in_lecture else [each.id in picture.state.done for each in picture.lesson.path]
    dots = "".join(f'<button type="button" class="ol-dot" data-to="{hand}" data-value="scene:{k}" '
                   f'aria-label="{k + 1}" aria-current="{"step" if k == at else "false"}"'
                   f'{" data-done" if is_done else ""}></button>' for k, is_done in enumerate(done))
    parts = [f'<div class="ol-where"><span>{at + 1}/{count}</span><nav class="ol-dots">{dots}</nav></div>',
             f'<h2 class="ol-scene">{html.escape(words.title)}</h2>', f'<div class="ol-text">{paragraphs(picture, words.text)}</div>']
    if isinstance(scene.do, Choose):
        parts.append(_options(picture, scene, hand))
    if words.do and scene.id not in picture.state.done:
        parts.append(f'<p class="ol-todo">{_emphasised(render_markdown(with_minus(live_numbers(picture, words.do))))}</p>')
    return f'<section class="ol-card" data-scene="{scene.id}">{"".join(parts)}</section>'


def _options(picture: Picture, scene: Scene, hand: str) -> str:
    options, _, answer = options_of(picture.lesson, scene, picture.state.language)
    chosen = picture.state.chosen.get(scene.id)
    told = answer if scene.id in picture.state.done and not picture.voting else None
    lit = told if picture.votes else None  # the class has voted
    marks = [(" ol-chosen" if k == chosen else "") + (" ol-true" if k == told else "") + (" ol-right" if k == lit else "")
             for k in range(len(options))]
    buttons = [f'<button type="button" class="ol-option{marks[k]}" data-to="{hand}" data-value="option:{k}"'
               f'{"" if chosen is None else " disabled"}><b>{LETTERS[k]}</b> {render_markdown(option)}</button>'
               for k, option in enumerate(options)]
    return f'<div class="ol-choice">{"".join(buttons)}</div>'


def verdict_html(picture: Picture, hand: str) -> str:
    """What is said once the scene's action is done, and the buttons back and next."""
    scene, words, lang = picture.scene, picture.scene_words, picture.state.language
    assert scene is not None
    done, (at, count) = scene.id in picture.state.done, picture.place
    said = ""
    if picture.voting:
        done = False  # once more: nothing shows the answer
    elif isinstance(scene.do, Choose) and scene.id in picture.state.chosen:
        said = _verdict(picture, scene) if done else f'<p class="ol-note">{html.escape(phrases.WATCH(lang))}</p>'
    if (done and words.say and not isinstance(scene.do, Read)) or (done and words.say and scene.play):
        said += f'<div class="ol-say">{paragraphs(picture, words.say)}</div>'
    skip = not done
    back = "" if at == 0 else (f'<button type="button" class="ol-do" data-to="{hand}" data-value="turn:-1">'
                               f"{html.escape(phrases.BACK_SCENE(lang))}</button>")
    if at + 1 < count:
        words_on, value = (phrases.SKIP_SCENE if skip else phrases.NEXT_SCENE), "turn:1"
    elif picture.state.talk is not None:
        words_on, value = phrases.END_LECTURE, "end"
    else:
        words_on, value = phrases.TO_LAB, "mode:lab"
    on = (f'<button type="button" class="{"ol-do" if skip else "ol-next"}" data-to="{hand}" data-value="{value}">'
          f"{html.escape(words_on(lang))}</button>")
    return (f'<div class="ol-answer" role="status" aria-live="polite">{said}</div><div class="ol-way">{back}{on}</div>')


def _verdict(picture: Picture, scene: Scene) -> str:
    lang, chosen = picture.state.language, picture.state.chosen[scene.id]
    _, refutations, answer = options_of(picture.lesson, scene, lang)
    if chosen < 0:
        return ""
    told = phrases.YOU_CHOSE_RIGHT if chosen == answer else phrases.YOU_CHOSE.format(letter=LETTERS[chosen], answer=LETTERS[answer])
    refuted = refutations[chosen] if chosen < len(refutations) and chosen != answer else ""
    return judged_html(chosen == answer, told(lang)) + (f'<div class="ol-say">{paragraphs(picture, refuted)}</div>' if refuted else "")


def formulas_html(picture: Picture) -> str:
    """The live equations that the scene shows."""
    scene = picture.scene
    assert scene is not None
    shown = [f for f in picture.outcome.formulas if f.id in scene.formulas] if scene.formulas else []
    return "".join(formula_html(f.latex) for f in shown)
