"""Write a run as one HTML page that plays without server or network: stage, clock and figures."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from string import Template

import numpy as np

from ...course.design_differences import describe_design, value_in_words
from ...course.figures.records import Figure, MapFigure, tab_names
from ...export.figures.figure_pages import FigureImage, draw_figure_images
from ...export.files import FileError, check_fonts_for
from ...session.handlers.playback import PLAYBACK_SPEEDS
from ...session.state.view import Picture
from ...text import text
from .. import web
from ..web.html_page import APP_NAME, recording_page
from ..words import phrases
from .recording import record_run

POLICY = ("default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob: data:; style-src 'unsafe-inline'; img-src data: blob:; "
          "font-src data:; media-src data: blob:; worker-src data: blob:; connect-src data: blob:; base-uri 'none'; form-action 'none'")
NO_RUN = text("This design has no run in time, so there is nothing to play; take its figures instead.")


def replay(picture: Picture, token: str, camera: tuple[float, ...] | None = None) -> str:
    """The page of a picture, in its language and theme, with the token of its state in its head.

    `camera` is position and target to look from at first, None for the whole view. Raises FileError where nothing moves in time.
    """
    lang, state = picture.state.language, picture.state
    if picture.horizon <= 0:
        raise FileError(NO_RUN)
    check_fonts_for(lang)
    title = picture.lesson.words[lang].title
    head = (f'<meta http-equiv="Content-Security-Policy" content="{POLICY}"><meta name="observer-lab-state" content="{_safe(token)}">'
            + style())
    words = {"play": phrases.PLAY(lang), "pause": phrases.PAUSE(lang)}
    return recording_page(record_run(picture, camera, words), lang, f"{title} · {APP_NAME}", head, _beside(picture), state.is_dark)


def style() -> str:
    """The style element of the page: colours of the lab's own page, and its own layout."""
    return f"<style>{web.style_rules('viser_dom.css', 'page.css', 'replay.css')}</style>"


def _safe(words: str) -> str:
    return html.escape(words, quote=True)


def _beside(picture: Picture) -> str:
    """All that stands about the stage: question, transport, figures, knobs."""
    lang, lesson, stage = picture.state.language, picture.lesson, picture.outcome.stage
    assert stage is not None
    words = lesson.words[lang]
    said = {name: _safe(meant(lang)) for name, meant in (
        ("wait", phrases.STAGE_COMES), ("transport", phrases.TRANSPORT), ("play", phrases.PLAY), ("rewind", phrases.REWIND),
        ("time", phrases.TIME), ("speed", phrases.SPEED), ("view", phrases.VIEW), ("knobs", phrases.KNOBS))}
    speeds = "".join(f'<option value="{times:g}"{" selected" if times == 1 else ""}>{times:g}×</option>' for times in PLAYBACK_SPEEDS)
    return Template(web.file_text("replay.html")).substitute(
        said, title=_safe(words.title), question=_safe(words.question), standing=_safe(describe_design(lesson, picture.design)(lang)),
        begin=f"{stage.t[0]:g}", end=f"{stage.t[-1]:.9g}", speeds=speeds, live=_live(picture), values=_values(picture),
        figures=_figures(picture))


def _live(picture: Picture) -> str:
    """What is seen now, in a sentence, and what stands on the stage."""
    lang, stage = picture.state.language, picture.outcome.stage
    caption = stage.body.caption(lang) if stage is not None else ""
    return "".join(f'<p class="ol-replay-live">{_safe(words)}</p>' for words in (picture.outcome.live(lang), caption) if words)


def _values(picture: Picture) -> str:
    """Every knob that matters now, with its value."""
    lang, lesson, design = picture.state.language, picture.lesson, picture.design
    rows = [(knob.label(lang), f"{value_in_words(knob, design[knob.name])(lang)} {knob.unit}".strip()) for knob in lesson.knobs
            if lesson.shown(knob, design)]
    return "".join(f"<tr><td>{_safe(label)}</td><td>{_safe(value)}</td></tr>" for label, value in rows)


def _figures(picture: Picture) -> str:
    """All figures that show something, with titles and captions, under the names of their tabs; pins and their table too."""
    lang = picture.state.language
    figures = [*picture.seen, *([picture.compared] if picture.compared is not None else [])]
    figures = [figure for figure in figures if not isinstance(figure, MapFigure) or np.any(figure.values >= 0)]
    return "".join(f"<h2>{_safe(tab(lang))}</h2>{_drawn([f for f in figures if f.tab == tab], lang)}" for tab in tab_names(figures))


def _drawn(figures: Sequence[Figure], lang: str) -> str:
    return "".join(f'<figure><h3>{_safe(plate.figure.title(lang))}</h3>'
                   f'<div class="ol-replay-plot">{_image(plate, lang)}{_cursor(plate)}</div>'
                   f"<figcaption>{_safe(plate.figure.caption(lang))}</figcaption></figure>" for plate in draw_figure_images(figures, lang))


def _image(plate: FigureImage, lang: str) -> str:
    """An element of its own, so that no name in one picture meets that in another."""
    return f'<img alt="{_safe(plate.figure.title(lang))}" src="data:image/svg+xml;base64,{base64.b64encode(plate.svg).decode()}">'


def _cursor(plate: FigureImage) -> str:
    """The line that goes over a figure with the clock; nothing where it is not over time."""
    span = plate.span
    if span is None:
        return ""
    place = f"top:{span.top:.2%};bottom:{1 - span.bottom:.2%};--ol-left:{span.left:.3%};--ol-wide:{span.right - span.left:.3%}"
    return f'<i class="ol-replay-now" hidden data-from="{span.begin:.9g}" data-to="{span.end:.9g}" style="{place}"></i>'
