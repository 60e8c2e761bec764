"""What every path shows: a figure for each question, a hand on something by the second scene, hardly a scene without a picture."""

from __future__ import annotations

from laws import each
from show_table import row

from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS

LATEST_TOUCH, MOST_WORDS = 2, 60  # the scene, counted from 1, and the words up to it
MOST_BARE, LEAST_BY_HAND = 10, 8  # scenes without a picture in all lessons; lessons in which one answers by hand


@each("lesson", LESSONS.values())
def test_a_hand_is_on_something_by_the_second_scene_and_every_question_has_its_figure(lesson: Lesson) -> None:
    shown = row(lesson)
    assert shown.touch <= LATEST_TOUCH and shown.words <= MOST_WORDS, (shown.touch, shown.words)
    assert shown.drawn == shown.questions > 0


def test_hardly_a_scene_is_without_a_picture_and_many_questions_are_answered_by_hand() -> None:
    rows = [row(lesson) for lesson in LESSONS.values()]
    assert sum(each.bare for each in rows) <= MOST_BARE
    assert sum(each.by_hand > 0 for each in rows) >= LEAST_BY_HAND
