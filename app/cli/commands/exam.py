"""Print the exams of a lesson for a student's key, with answers and derivations: `exam`."""

from __future__ import annotations

import argparse

from ...text.languages import languages
from ..options import CommandError, add_own_lessons, whole_number

HELP = "the exams of a lesson for a student's key outside a course, with answers"
MAX_VARIANT = 10**6


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `exam`."""
    parser.add_argument("lesson", metavar="LESSON", help="a lesson's name; see list")
    add_own_lessons(parser)
    parser.add_argument("--key", required=True, help="the student's key, as it is typed on the page")
    parser.add_argument(
        "--variant",
        type=whole_number(0, MAX_VARIANT, "is no variant; give a whole number, 0 for the withheld one"),
        default=0,
        metavar="N",
        help="which variant, 1 the first in practice; 0, unless given, the withheld one",
    )
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the words")


def execute(options: argparse.Namespace) -> int:
    """Print each exam in Markdown: statement, answer, derivation. Raises CommandError at a lesson that there is not."""
    from ...course.exercises.exam import seed_of
    from ...course.handin.exam_sheet import exam_sheet
    from ..inputs import find_lesson
    from ..lesson_folder import lessons_of

    lessons = lessons_of(options)
    lesson = find_lesson(options.lesson, lessons)
    if not lesson.exams:
        raise CommandError(f"Lesson {lesson.id} has no exams.")
    for exam in lesson.exams:
        print(exam_sheet(lesson, exam, exam.item(seed_of(options.key, lesson.id, exam.id, options.variant)), options.lang))
    return 0
