"""Write the page of a lecture: its scenes in order, each with a link to it in a published folder."""

from __future__ import annotations

import html
from collections.abc import Mapping
from urllib.parse import urlencode

from ...course.lectures import Lecture, Stop, words_in
from ...course.lesson import Lesson
from .. import web
from ..web.html_page import web_code
from ..words import phrases

POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"


def lecture_page(lecture: Lecture, lessons: Mapping[str, Lesson], language: str, home: str) -> str:
    """The page in a language; `home` is the page of the guide. The speaker's notes are not on it."""
    title = html.escape(words_in(lecture.title, language))
    told = html.escape(phrases.LECTURE_STOPS.format(minutes=lecture.minutes, count=len(lecture.stops))(language))
    stops = "".join(f"<li>{_link(stop, k, lessons[stop.lesson], language, home)}</li>" for k, stop in enumerate(lecture.stops))
    return (f'<!doctype html><html lang="{web_code(language)}"><head><meta charset="utf-8"><title>{title}</title>'
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}"><meta name="viewport" content="width=device-width">'
            f"<style>{web.style_rules('questions.css')}</style></head><body><main><h1>{title}</h1><p>{told}</p><ol>{stops}</ol></main>"
            "</body></html>")


def _link(stop: Stop, number: int, lesson: Lesson, language: str, home: str) -> str:
    words = lesson.words[language]
    link = f"{home}?{urlencode({'lesson': lesson.id, 'lang': language, 'scene': stop.scene, 'stop': number})}"
    said = f"{lesson.number} · {words.title}: {words.scenes[stop.scene].title}"
    return f'<a href="{html.escape(link, quote=True)}">{html.escape(said)}</a>'
