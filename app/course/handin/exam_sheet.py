"""Write an exam with a student's numbers, the answer and the derivation as Markdown."""

from __future__ import annotations

from ...text import joined, same
from ..exercises.derivation import fill_placeholders
from ..exercises.exam import Exam, ExamItem
from ..lesson import Lesson


def exam_parts(lesson: Lesson, exam: Exam, item: ExamItem, language: str) -> tuple[str, str, str]:
    """Title, statement, and answer with derivation of an exam."""
    words = lesson.words[language].exams[exam.id]
    statement = joined(same(fill_placeholders(words.statement, item.given)), exam.digits.asked)(language)
    return words.title, statement, f"**{exam.digits.written(item.answer)}**\n\n{exam.derived(words.derivation, item)}"


def exam_sheet(lesson: Lesson, exam: Exam, item: ExamItem, language: str) -> str:
    """Title, statement, answer and derivation of an exam on one page."""
    title, statement, solution = exam_parts(lesson, exam, item, language)
    return f"## {title}\n{statement}\n\n{solution}\n"
