"""Write the pages of a published folder: of lessons, of lectures, and of questions people ask."""

from __future__ import annotations

import html
from base64 import b64encode
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from urllib.parse import urlencode

from ...course.lectures import Lecture, Stop, words_in
from ...course.lesson import Lesson
from ...course.search.questions import AskedQuestion, questions
from ...session.handlers.playback import PLAYBACK_SPEEDS
from .. import web
from ..stage.viewpoint import BOARD_HEIGHT, BOARD_WIDTH
from ..web.html_page import APP_NAME, viser_page, web_code
from ..words import phrases
from .recorded_screen import WINDOWS

POLICY = ("default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; style-src 'unsafe-inline'; "
          "img-src data: blob:; font-src data:; media-src data: blob:; worker-src data: blob:; connect-src data: blob:; base-uri 'none'; "
          "form-action 'none'")
BUTTONS = (("play", phrases.PLAY), ("pause", phrases.PAUSE), ("kick", phrases.KICK), ("rewind", phrases.REWIND),
           ("slower", phrases.SLOWER), ("faster", phrases.FASTER), ("next", phrases.NEXT_SCENE), ("back", phrases.BACK_SCENE),
           ("lacks", phrases.NOT_PUBLISHED))
LECTURE_POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
QUESTIONS_POLICY = ("default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'unsafe-inline'; base-uri 'none'; "
                    "form-action 'none'")


def published_page(languages: Sequence[str], lessons: Sequence[str], looks: Sequence[str], data: str,
                   stops: Sequence[tuple[str, str]] = (), lecture: Mapping[str, str] = MappingProxyType({})) -> str:
    """The page that shows these lessons in these looks from the folder `data` beside it.

    Next and Back follow the stops of a lecture, lesson and scene each, and lead at its ends to the page of the lecture in the language.
    """
    words = {code: {name: button(code) for name, button in BUTTONS} for code in languages}
    script = web.script_call("published", lessons=list(lessons), looks=list(looks), words=words,
                             web={code: web_code(code) for code in languages}, speeds=list(PLAYBACK_SPEEDS),
                             stops=list(stops), lecture=dict(lecture), board=[BOARD_WIDTH, BOARD_HEIGHT / 2],
                             shapes={width: canvas[0] / canvas[1] for width, (_, canvas) in WINDOWS.items()})
    return viser_page(APP_NAME, f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
                                f'<meta name="viewport" content="width=device-width,initial-scale=1">'
                                f"<style>{web.coloured_text('published.css')}{web.font_rules()}</style>"
                                f"<script>{web.script_call('viser_dom')}</script><script>{web.script_call('software')}</script>"
                                f"<script>{web.script_call('folded')}</script><script>{web.script_call('breadth')}</script>"
                                f"<script>{web.script_call('packed', folder=data)}</script><script>{script}</script>")


def lecture_page(lecture: Lecture, lessons: Mapping[str, Lesson], language: str, home: str) -> str:
    """The page in a language; `home` is the page of the guide. The speaker's notes are not on it."""
    title = html.escape(words_in(lecture.title, language))
    told = html.escape(phrases.LECTURE_STOPS.format(minutes=lecture.minutes, count=len(lecture.stops))(language))
    stops = "".join(f"<li>{_link(stop, k, lessons[stop.lesson], language, home)}</li>" for k, stop in enumerate(lecture.stops))
    return (f'<!doctype html><html lang="{web_code(language)}"><head><meta charset="utf-8"><title>{title}</title>'
            f'<meta http-equiv="Content-Security-Policy" content="{LECTURE_POLICY}"><meta name="viewport" content="width=device-width">'
            f"<style>{web.style_rules('questions.css')}</style></head><body><main><h1>{title}</h1><p>{told}</p><ol>{stops}</ol></main>"
            "</body></html>")


def _link(stop: Stop, number: int, lesson: Lesson, language: str, home: str) -> str:
    words = lesson.words[language]
    link = f"{home}?{urlencode({'lesson': lesson.id, 'lang': language, 'scene': stop.scene, 'stop': number})}"
    said = f"{lesson.number} · {words.title}: {words.scenes[stop.scene].title}"
    return f'<a href="{html.escape(link, quote=True)}">{html.escape(said)}</a>'


def questions_page(lessons: Mapping[str, Lesson], language: str, home: str) -> str:
    """The page in a language, about those questions that these lessons answer; `home` is the page of the guide."""
    asked = questions()[language]
    shown = [each for each in asked.entries if each.lesson in lessons]
    pictures = "".join(_picture(lessons[id]) for id in dict.fromkeys(each.lesson for each in shown))
    title = html.escape(asked.title)
    return (f'<!doctype html><html lang="{web_code(language)}"><head><meta charset="utf-8"><title>{title}</title>'
            f'<meta http-equiv="Content-Security-Policy" content="{QUESTIONS_POLICY}"><meta name="viewport" content="width=device-width">'
            f"<style>{web.style_rules('questions.css')}{pictures}</style></head><body><main><h1>{title}</h1>"
            f'<label>{html.escape(phrases.SEARCH(language))} <input type="search" class="ol-words"></label>'
            f"{''.join(_entry(each, lessons[each.lesson], language, home) for each in shown)}</main>"
            f"<script>{web.script_call('questions')}</script></body></html>")


def _entry(question: AskedQuestion, lesson: Lesson, language: str, home: str) -> str:
    words = lesson.words[language]
    link = f"{home}?{urlencode({'lesson': lesson.id, 'lang': language, 'scene': question.scene})}"
    name = f'<p><code>observer_lab.engine.{question.name}</code></p>' if question.name else ""
    told = " ".join((question.title, *question.phrases)).lower()
    return (f'<section id="{question.id}" data-words="{html.escape(told, quote=True)}"><h2>{html.escape(question.title)}</h2>'
            f'<i class="ol-shot-{lesson.id}" role="img" aria-label="{html.escape(words.title, quote=True)}"></i>'
            f"<p>{html.escape(question.answer)}</p>{name}"
            f'<p><a href="{html.escape(link, quote=True)}">{lesson.number} · {html.escape(words.title)}: '
            f"{html.escape(words.scenes[question.scene].title)}</a></p></section>")


def _picture(lesson: Lesson) -> str:
    path = lesson.place.picture
    if path is None or not path.is_file():
        return ""
    return f".ol-shot-{lesson.id}{{background-image:url(data:image/webp;base64,{b64encode(path.read_bytes()).decode('ascii')})}}"
