"""Write the page *Questions people ask*: each with its answer, a picture and a link to its scene."""

from __future__ import annotations

import html
from base64 import b64encode
from collections.abc import Mapping
from urllib.parse import urlencode

from ...course.lesson import Lesson
from ...course.search.questions import AskedQuestion, questions
from .. import web
from ..web.html_page import web_code
from ..words import phrases

POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"


def questions_page(lessons: Mapping[str, Lesson], language: str, home: str) -> str:
    """The page in a language, about those questions that these lessons answer; `home` is the page of the guide."""
    asked = questions()[language]
    shown = [each for each in asked.entries if each.lesson in lessons]
    pictures = "".join(_picture(lessons[id]) for id in dict.fromkeys(each.lesson for each in shown))
    title = html.escape(asked.title)
    return (f'<!doctype html><html lang="{web_code(language)}"><head><meta charset="utf-8"><title>{title}</title>'
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}"><meta name="viewport" content="width=device-width">'
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
