"""Show the page on which a teacher chooses a lesson, and sign each answer for the platform.

Source: IMS Global, "LTI Deep Linking 2.0", sections 3 and 4.
"""

from __future__ import annotations

import html
import secrets
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import urlencode, urlsplit

from ...course.handin.course_file import Course
from ...course.lesson import Lesson
from .. import web
from ..web.html_page import APP_NAME, web_code
from ..words import phrases
from .keys import ToolKeys
from .launch import CLAIM, DEEP_LINKING, LINK_TYPE, Launch

CHOICE_S = 3600  # s for which an answer holds: so long may a teacher look at the page


def points_of(course: Course | None, lesson: str) -> float:
    """The points that a lesson can bring, or all lessons for ""; 0 outside a course."""
    items = () if course is None else course.items.values()
    return sum(item.points for item in items if not item.practice and lesson in ("", item.lesson))


def choice_page(launch: Launch, lessons: Mapping[str, Lesson], course: Course | None, language: str, address: str, keys: ToolKeys,
                now: int) -> str:
    """A form with one button a lesson; each holds its answer, signed, so that nothing is kept meanwhile."""
    buttons = "".join(
        f'<p><button name="JWT" value="{_answer(launch, place, title, points, address, keys, now)}">'
        f"{html.escape(title)}</button></p>" for place, title, points in _choices(lessons, course, language))
    code = web_code(language)
    return (f'<!doctype html><html lang="{code}"><head><meta charset="utf-8"><title>{APP_NAME}</title>'
            f'<meta name="viewport" content="width=device-width"><style>{web.coloured_text("link.css")}</style></head>'
            f'<body><main class="ol-linking"><h1>{html.escape(phrases.CHOOSE_LESSON(language))}</h1>'
            f'<form method="post" action="{html.escape(launch.returns)}">{buttons}</form></main></body></html>')


def form_origin(address: str) -> str:
    """The site to which the form of a page may go."""
    parts = urlsplit(address)
    return f"{parts.scheme}://{parts.netloc}"


def _choices(lessons: Mapping[str, Lesson], course: Course | None, language: str) -> Iterator[tuple[dict[str, str], str, float]]:
    """What a launch may open: fields of its address, title and points. After each lesson stand its exams and tasks that are handed in."""
    yield {}, phrases.ALL_LESSONS(language) if course is None else course.title, points_of(course, "")
    for lesson in lessons.values():
        words = lesson.words[language]
        yield {"lesson": lesson.id}, words.title, points_of(course, lesson.id)
        for item in () if course is None else course.items.values():
            if item.lesson == lesson.id and not item.practice:
                title = words.exams[item.id].title if item.kind == "exam" else words.tasks[item.id].title
                yield {"lesson": lesson.id, item.kind: item.id}, f"{words.title}: {title}", item.points


def _answer(launch: Launch, place: Mapping[str, str], title: str, points: float, address: str, keys: ToolKeys, now: int) -> str:
    item: dict[str, Any] = {"type": LINK_TYPE, "title": title, "url": address.rstrip("/") + "/lti/launch"}
    if place:
        item |= {"url": f"{item['url']}?{urlencode(place)}", "custom": dict(place)}
    if points:
        item["lineItem"] = {"scoreMaximum": points, "label": title, "resourceId": " ".join(place.values()) or "course"}
    platform = launch.platform
    claims = {"iss": platform.client_id, "aud": platform.issuer, "iat": now, "exp": now + CHOICE_S, "nonce": secrets.token_urlsafe(16),
              f"{CLAIM}deployment_id": launch.deployment, f"{CLAIM}message_type": "LtiDeepLinkingResponse", f"{CLAIM}version": "1.3.0",
              f"{DEEP_LINKING}content_items": [item]}
    return keys.sign(claims if launch.data is None else {**claims, f"{DEEP_LINKING}data": launch.data})
