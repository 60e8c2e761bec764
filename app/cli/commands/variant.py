"""Print the items of a course for a student's key, with answers: `variant`."""

from __future__ import annotations

import argparse

from ...text.languages import languages
from ..options import CommandError, add_json, whole_number

HELP = "the items of a course for a student's key, with answers"
MAX_VARIANT = 10**6


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `variant`."""
    parser.add_argument("key", metavar="KEY", help="the student's key, as it is typed on the page")
    parser.add_argument("--course", required=True, metavar="FILE", help="the course file")
    parser.add_argument("--lesson", metavar="LESSON", help="this lesson alone (default: all of the course)")
    parser.add_argument(
        "--variant",
        type=whole_number(0, MAX_VARIANT, "is no variant; give a whole number, 0 for the withheld one"),
        metavar="N",
        help="which variant (default: 0, the one that is handed in; 1, the first, where the item is for practice)",
    )
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the words")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print each exam of the course in Markdown, or as JSON. Raises CommandError."""
    from observer_lab.lessons import LESSONS

    from ...course.exercises.exam import canonical_key
    from ...course.handin.exam_sheet import exam_sheet
    from ...course.handin.served_course import student_item
    from ...export.data.data import plain
    from ..courses import course_in
    from ..printing import print_json

    course = course_in(options.course)
    if not canonical_key(options.key):
        raise CommandError("The student's key is empty; give it as it is typed on the page.")
    asked = [item for item in course.items.values() if item.kind == "exam" and options.lesson in (None, item.lesson)]
    if not asked:
        there = ", ".join(dict.fromkeys(item.lesson for item in course.items.values() if item.kind == "exam")) or "none"
        raise CommandError(f"Course {course.id} has no exam here; lessons with exams: {there}.")
    records = []
    for place in asked:
        lesson, variant = LESSONS[place.lesson], options.variant if options.variant is not None else int(place.practice)
        exam = next(exam for exam in lesson.exams if exam.id == place.id)
        item = student_item(course, options.key, lesson.id, exam, variant)
        if not options.json:
            print(exam_sheet(lesson, exam, item, options.lang))
        answer = exam.digits.written(item.answer)
        records.append({"item": place.name, "variant": variant, "given": plain(dict(item.given)), "answer": answer})
    if options.json:
        print_json({"course": course.id, "key": options.key, "items": records})
    return 0
