"""Tasks, predictions and exam items of every lesson."""

from __future__ import annotations

import math
import string
from collections import Counter
from typing import Any

import pytest
from laws import each
from lesson_checks import check_markdown, complete, every_lesson, shown

from app.lesson.lesson import ExamItem, Lesson
from app.text import languages
from lessons import LESSONS

SEEDS = range(1, 13)


def every_task() -> list[Any]:
    return [pytest.param(lesson, task, id=f"{lesson.id}-{task.id}") for lesson in LESSONS.values() for task in lesson.tasks]


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
    assert 2 <= len(lesson.tasks) <= 8
    assert len({t.id for t in lesson.tasks}) == len(lesson.tasks)
    for language in languages():
        options = lesson.words[language].options
        assert 3 <= len(options) <= 4 and len(set(options)) == len(options)
        assert 0 <= lesson.answer < len(options)
    assert lesson.source.strip()


def test_the_letters_of_right_predictions_are_spread_evenly() -> None:
    """Whoever always presses the same letter is right in at most three lessons of ten."""
    letters = Counter(lesson.answer for lesson in LESSONS.values())
    assert set(letters) == set(range(4)) and max(letters.values()) <= 0.3 * len(LESSONS), letters


@every_lesson
def test_exam_items_differ_between_students_and_fit_the_text(lesson: Lesson) -> None:
    items: list[ExamItem] = [lesson.exam(seed) for seed in SEEDS]
    assert len({item.answer for item in items}) > len(items) // 3
    assert all(math.isfinite(item.answer) and math.isfinite(item.tolerance) and item.tolerance > 0 for item in items)
    for seed, item in zip(SEEDS, items, strict=True):
        assert lesson.exam(seed) == item
        drawn = [lesson.words[language].exam.format(**item.numbers) for language in languages()]
        for language, text in zip(languages(), drawn, strict=True):
            check_markdown(text, f"exam {language}")
            assert "None" not in text and "nan" not in text


@every_lesson
def test_the_exam_text_uses_the_same_numbers_in_both_languages(lesson: Lesson) -> None:
    used = {lang: {name for _, name, _, _ in string.Formatter().parse(lesson.words[lang].exam) if name} for lang in languages()}
    assert used["en"] == used["zh"] == set(lesson.exam(1).numbers)
