"""Write the card of a scene as HTML: its place in the path, text, options, verdict and the way on."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...course.design_differences import describe_step
from ...course.figures.records import PlaneFigure
from ...course.guiding.goals import judge_move
from ...course.guiding.predictions import LETTERS, prediction_of
from ...course.lectures import words_in
from ...course.lesson import Outcome
from ...course.scenes import Choose, Move, Scene, Solve, fill_numbers
from ...session.state.view import Picture
from ...text import format_number
from ..charts.print_sizes import Sizes
from ..charts.svg import draw, sketch_frame
from ..votes.class_drawings import drawings_html
from ..words import phrases, prediction
from ..words.menu import menu_html, mode_switch
from ..words.prediction import options_html
from ..words.prose import explained_html, formula_html, mathml, render_markdown, with_minus
from .figure_room import room_for_question

MARKS = ("gone", "lit", "gather", "turn")


def live_numbers(picture: Picture, words: str, outcome: Outcome | None = None) -> str:
    """Words with the numbers of an outcome, else the picture's, in their places; a dash where one is not known.

    What never happens is infinite: "never" stands there, without the unit that a place may name after its format.
    """
    run = outcome or picture.outcome
    numbers: Mapping[str, Any] = {**dict(run.design.values), **run.metrics}

    def number(name: str, spec: str) -> str:
        value, (form, _, unit) = numbers.get(name), spec.partition(" ")
        if isinstance(value, (bool, str)) or value is None or np.isnan(value):
            return "–"
        if np.isinf(value) and unit:
            return phrases.NEVER(picture.state.language)
        return format_number(float(value), form, picture.state.language) + (f" {unit}" if unit else "") if np.isfinite(value) else "–"
    return fill_numbers(words, number)


def paragraphs(picture: Picture, words: str, outcome: Outcome | None = None) -> str:
    """Text of a scene as HTML: Markdown's emphasis, equations, and the numbers of an outcome, else the picture's."""
    text = "".join(f"<p>{_emphasised(render_markdown(with_minus(live_numbers(picture, part, outcome))))}</p>"
                   for part in words.split("\n\n") if part.strip())
    return explained_html(picture.lesson.words[picture.state.language], text)


def _emphasised(words: str) -> str:
    parts = words.split("*")
    return words if len(parts) % 2 == 0 else "".join(f"<b>{part}</b>" if k % 2 else part for k, part in enumerate(parts))


def mode_row(picture: Picture, hand: str) -> str:
    """The switch between guide, lab and present, and the button of the page of lessons."""
    lang, now = picture.state.language, picture.state.mode
    talk = picture.state.talk
    items = [("end", phrases.END_LECTURE(lang))] if talk is not None else []
    items += [("record", phrases.RECORD_STOP(lang))]
    if picture.state.recorded:
        items += [("save", phrases.SAVE_LECTURE.format(count=len(picture.state.recorded))(lang))]
    title = f"{picture.lesson.number} · {picture.lesson.words[lang].title}"
    whole = title if talk is None else f"{words_in(talk.title, lang)} · {title}"
    hall = " ol-present" if now == "present" else ""
    return (f'<div class="ol-head{hall}"><button type="button" class="ol-menu" data-to="{hand}" data-value="course" '
            f'aria-label="{html.escape(phrases.COURSE(lang), quote=True)}">☰</button>'
            f'<span class="ol-lesson" title="{html.escape(whole, quote=True)}">{html.escape(title)}</span>'
            f"{mode_switch(now, lang, hand)}"
            f"{menu_html(picture, hand, items, [('reset', phrases.RESET(lang))])}</div>")


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
             f'<h1 class="ol-scene">{html.escape(words.title)}</h1>',
             f'<div class="ol-text">{paragraphs(picture, words.text, picture.asked)}</div>']
    if isinstance(scene.do, Choose):
        parts.append(_options(picture, scene, hand))
    if words.do:
        done = " data-done" if scene.id in picture.state.done else ""
        parts.append(f'<p class="ol-todo"{done}>{_emphasised(render_markdown(with_minus(live_numbers(picture, words.do))))}</p>')
    return f'<section class="ol-card" data-scene="{scene.id}">{"".join(parts)}</section>'


def _options(picture: Picture, scene: Scene, hand: str) -> str:
    asked, chosen = prediction_of(picture.lesson, scene, picture.state.language), picture.state.chosen.get(scene.id)
    told = asked.answer if scene.id in picture.state.done and not picture.undecided else None
    lit = told if picture.votes else None  # the class has voted
    buttons = options_html([render_markdown(words) for words in asked.options],
                           None if chosen is not None else lambda k: f'data-to="{hand}" data-value="option:{k}"',
                           lambda k: (" ol-chosen" if k == chosen else "") + (" ol-true" if k == told else "")
                           + (" ol-right" if k == lit else ""))
    return f'<div class="ol-choice">{buttons}</div>'


def verdict_html(picture: Picture, hand: str) -> str:
    """What is said once the scene's action is done, with the numbers of the run that did it, and the buttons back and next."""
    scene, words, lang = picture.scene, picture.scene_words, picture.state.language
    assert scene is not None
    done, (at, count) = scene.id in picture.state.done, picture.place
    said = ""
    if picture.undecided:
        done = False  # once more: nothing shows the answer
    elif isinstance(scene.do, Choose) and scene.id in picture.state.chosen:
        said = _verdict(picture, scene) if done else f'<p class="ol-note">{html.escape(phrases.WATCH(lang))}</p>'
    if done and words.say and scene.answers:
        said += f'<div class="ol-say">{paragraphs(picture, words.say, picture.kept)}</div>' + _changed_since(picture, scene, hand)
    elif remark := _remark(picture, scene):
        said += f'<div class="ol-say"><p>{_emphasised(render_markdown(with_minus(remark)))}</p></div>'
    skip = not done
    back = "" if at == 0 else (f'<button type="button" class="ol-do" data-to="{hand}" data-value="turn:-1">'
                               f"{html.escape(phrases.BACK_SCENE(lang))}</button>")
    if at + 1 < count:
        words_on, value = (phrases.SKIP_SCENE if skip else phrases.NEXT_SCENE), "turn:1"
    elif picture.state.talk is not None:
        words_on, value = phrases.END_LECTURE, "end"
    else:
        words_on, value = phrases.TO_LAB, "mode:lab"
    on = (f'<button type="button" class="{"ol-do ol-skip" if skip else "ol-next"}" data-to="{hand}" data-value="{value}">'
          f"{html.escape(words_on(lang))}</button>")
    return (f'<div class="ol-answer" role="status" aria-live="polite">{said}</div><div class="ol-way">{back}{on}</div>')


def _remark(picture: Picture, scene: Scene) -> str:
    """What a hand has done that the scene did not ask for, "" where there is nothing to say."""
    if not isinstance(scene.do, Move) or picture.began is None or not picture.resting:
        return ""
    return judge_move(picture.lesson, scene.do, picture.began, picture.design)[1](picture.state.language)


def _changed_since(picture: Picture, scene: Scene, hand: str) -> str:
    """That the knobs have been moved since the run of the verdict, what holds of them, and the way back to that run."""
    if picture.kept is None or picture.kept.design == picture.design or picture.state.performance is not None or not picture.resting:
        return ""
    lang = picture.state.language
    step = describe_step(picture.lesson, picture.kept.design, picture.design)(lang)
    now = phrases.CHANGED_SINCE.format(step=step)(lang)
    if isinstance(scene.do, Solve):
        task = next(each for each in picture.lesson.tasks if each.id == scene.do.task)
        now += " " + task.judge(picture.outcome).text(lang)
    elif remark := _remark(picture, scene):
        now += " " + remark.replace("*", "")
    return (f'<p class="ol-note">{html.escape(with_minus(now))} <button type="button" class="ol-do" data-to="{hand}" data-value="kept">'
            f"{html.escape(phrases.SHOW_KEPT(lang))}</button></p>")


def _verdict(picture: Picture, scene: Scene) -> str:
    lang, chosen = picture.state.language, picture.state.chosen[scene.id]
    if chosen < 0:
        return ""
    asked = prediction_of(picture.lesson, scene, lang)
    refuted = asked.refutation(chosen)
    why = f'<div class="ol-say">{paragraphs(picture, refuted, picture.kept)}</div>' if refuted else ""
    return prediction.verdict_html(asked, chosen, lang, in_guide=True) + _measure(picture, scene, chosen) + why


def _measure(picture: Picture, scene: Scene, chosen: int) -> str:
    """How near a prediction that was drawn by hand is to the run; nothing where none was."""
    sketch, drawn, lang = picture.state.sketches.get(scene.id), picture.question, picture.state.language
    if sketch is None or drawn is None or len(sketch) != len(drawn.columns):
        return ""
    far = 100 * drawn.distance(sketch, drawn.run)
    return f'<p class="ol-note">{html.escape(phrases.SKETCH_MEASURE.format(letter=LETTERS[chosen], far=far)(lang))}</p>'


def question_html(picture: Picture, sizes: Sizes, hand: str) -> str:
    """The figure of the scene's question: what is known, then what was predicted, then what the run gives."""
    scene, state = picture.scene, picture.state
    if scene is None or picture.question is None:
        return ""
    answered, chosen = scene.id in state.done and not picture.undecided, state.chosen.get(scene.id)
    cloud = drawings_html(picture, picture.typed[-1]) if picture.typed and picture.typed[-1].kind == "sketch" else ""
    if cloud:
        return cloud
    figure = picture.question.drawn(chosen, answered, state.sketches.get(scene.id))
    asks = chosen is None and not answered
    asked = prediction_of(picture.lesson, scene, state.language)
    high = room_for_question(picture.scene_words.text, asked.options, sizes) if asks else sizes.question(True)
    drawn = draw(figure, state.language, sizes.large_words, high)
    return sketch_html(picture, figure, drawn, high, hand) if asks and picture.question.columns else drawn


def sketch_html(picture: Picture, figure: PlaneFigure, drawn: str, high: float, hand: str) -> str:
    """A question's figure into which a hand draws its prediction, and the button that sends it."""
    question, scene, lang = picture.question, picture.scene, picture.state.language
    assert question is not None and scene is not None
    send = f'<button type="button" class="ol-do" data-to="{hand}" disabled>{html.escape(phrases.PREDICT_THIS(lang))}</button>'
    return sketch_frame(question, figure, drawn, high, lang, f"{picture.lesson.id}/{scene.id}", phrases.SKETCH(lang), send)


def formulas_html(picture: Picture) -> str:
    """The algebra and the live equations that the scene shows."""
    scene = picture.scene
    assert scene is not None
    shown = [f for f in picture.outcome.formulas if f.id in scene.formulas] if scene.formulas else []
    lines = [live_numbers(picture, line) for line in scene.lines]
    return moving_lines(lines) + "".join(formula_html(f.latex) for f in shown)


# In a line `\color{gone}{…}` is struck out once all lines that hold such a term have come, and `\color{lit}{…}` lights up. A bracket
# grows under `\color{gather}{…}`: under terms that share a factor, then under what they become. `\color{turn}{…}` turns over its
# diagonal, as a transpose does. Where motion is unwanted the style sheet shows the last picture.
def moving_lines(lines: Sequence[str]) -> str:
    """The lines as HTML, each with its place in the order; nothing for none."""
    if not lines:
        return ""
    cut = max((k + 1 for k, line in enumerate(lines) if "{gone}" in line), default=0)
    return f'<div class="ol-formula ol-moving" style="--cut:{cut}">' + "".join(
        f'<div style="--at:{k}">{_marked(mathml(line, True))}</div>' for k, line in enumerate(lines)) + "</div>"


def _marked(markup: str) -> str:
    """MathML whose marks have become classes of the style sheet."""
    for mark in MARKS:
        markup = markup.replace(f'mathcolor="{mark}"', f'class="ol-{mark}"')
    return markup
