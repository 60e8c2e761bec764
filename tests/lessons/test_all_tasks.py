"""Tasks and predictions of every lesson."""

from __future__ import annotations

import re
from collections import Counter
from typing import Any

import pytest
from laws import each
from lesson_checks import complete, every_lesson, shown

from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.text import languages


def every_task() -> list[Any]:
    return [pytest.param(lesson, task, id=f"{lesson.id}-{task.id}") for lesson in LESSONS.values() for task in lesson.tasks]


@pytest.mark.slow
@each("lesson, task", every_task())
def test_a_task_fails_at_the_start_and_passes_at_its_own_solution(lesson: Lesson, task: Any) -> None:
    start = lesson.start()
    solved = shown(lesson.apply(start, task.solution))[0]
    before, after = task.judge(shown(start)[0]), task.judge(solved, task.typed.right(solved) if task.typed else "")
    assert not before.solved, before.text("en")
    assert after.solved, after.text("en")
    for verdict in (before, after):
        complete(verdict.text, "verdict")


@every_lesson
def test_there_are_tasks_and_a_right_prediction(lesson: Lesson) -> None:
    assert len({t.id for t in lesson.tasks}) == len(lesson.tasks)
    for language in languages():
        options = lesson.words[language].options
        assert 3 <= len(options) <= 4 and len(set(options)) == len(options)
        assert 0 <= lesson.answer < len(options)
    assert lesson.source.strip()


@every_lesson
def test_a_lesson_has_six_tasks_a_pencil_and_one_that_looks_back(lesson: Lesson) -> None:
    """The first lesson has none to look back at."""
    assert 6 <= len(lesson.tasks) <= 8
    assert any(task.typed is not None and task.typed.letters for task in lesson.tasks), "nothing to be done with a pencil"
    for language, named in (("en", r"[Ll]esson (\d+)"), ("zh", r"第 (\d+) 课")):
        words = " ".join(" ".join((task.statement, *task.hints)) for task in lesson.words[language].tasks.values())
        back = [int(number) for number in re.findall(named, words)]
        assert lesson.number == 1 or any(number < lesson.number for number in back), f"{language}: no earlier lesson is named"


def test_the_letters_of_right_predictions_are_spread_evenly() -> None:
    """Whoever always presses the same letter is right in at most three lessons of ten."""
    letters = Counter(lesson.answer for lesson in LESSONS.values())
    assert set(letters) == set(range(4)) and max(letters.values()) <= 0.3 * len(LESSONS), letters
