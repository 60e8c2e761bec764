"""Each lesson has a still picture and a short loop of its plant, alike in kind and small; the page of lessons shows them so."""

from __future__ import annotations

import re

import pytest
from PIL import Image, ImageSequence

from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page import web
from observer_lab.page.column.course_page import PICTURES, _loops, _stills

MOST_KB = {"card.webp": 12, "loop.webp": 60, "opening.webp": 20, "opening-loop.webp": 250}


def lasting(frame: Image.Image) -> int:
    """How long a frame stands, in ms."""
    frame.load()
    return frame.info["duration"]


@pytest.mark.parametrize("lesson", LESSONS.values(), ids=list(LESSONS))
def test_a_lesson_has_a_card_and_a_loop_of_the_same_stage(lesson: Lesson) -> None:
    card = lesson.place.picture
    assert card is not None
    loop = card.with_name("loop.webp")
    with Image.open(card) as still, Image.open(loop) as moving:
        assert still.size == moving.size == (300, 225) and getattr(still, "n_frames", 1) == 1
        assert moving.n_frames >= 10 and sum(lasting(frame) for frame in ImageSequence.Iterator(moving)) == 2000
    for path in (card, loop):
        assert path.stat().st_size < 1024 * MOST_KB[path.name], path.name


def test_the_opening_moves_and_is_small() -> None:
    with Image.open(PICTURES / "opening.webp") as still, Image.open(PICTURES / "opening-loop.webp") as moving:
        assert still.size == moving.size and moving.n_frames > 24
    for name in ("opening.webp", "opening-loop.webp"):
        assert (PICTURES / name).stat().st_size < 1024 * MOST_KB[name]


def test_nothing_moves_on_the_page_of_lessons_where_motion_is_unwanted() -> None:
    lessons = list(LESSONS.values())
    stills, loops = _stills(lessons), _loops(lessons)
    assert stills.count("--ol-still:url(") == loops.count("--ol-loop:url(") == len(LESSONS) + 1
    sheets = "".join(web.file_text(name) for name in ("page.css", "guide.css"))
    moving = re.findall(r"@media \(prefers-reduced-motion:no-preference\)[^{]*\{(?:[^{}]*\{[^{}]*\})*\s*\}", sheets)
    assert sum(part.count("var(--ol-loop") for part in moving) == sheets.count("var(--ol-loop") > 0
