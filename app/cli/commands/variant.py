"""Print a student's items of a course with answers, or the words of all students: `variant`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ...text.languages import languages
from ..options import CommandError, add_json, add_own_lessons, whole_number

if TYPE_CHECKING:
    from ...course.handin.course_file import Course

HELP = "the items of a course for a student's key, with answers; or with --words the words of students"
MAX_VARIANT = 10**6


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `variant`."""
    parser.add_argument("key", metavar="KEY", help="the student's key, as it is typed on the page; with --words also a file, a key a line")
    parser.add_argument("--words", action="store_true", help="print key and word, as CSV: give each student theirs")
    parser.add_argument("--course", required=True, metavar="FILE", help="the course file")
    parser.add_argument("--lesson", metavar="LESSON", help="this lesson alone (default: all of the course)")
    parser.add_argument(
        "--variant",
        type=whole_number(0, MAX_VARIANT, "is no variant; give a whole number, 0 for the withheld one"),
        metavar="N",
        help="which variant (default: 0, the one that is handed in; 1, the first, where the item is for practice)",
    )
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the words")
    add_own_lessons(parser)
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print each exam of the course in Markdown, or as JSON. Raises CommandError."""
    from ...course.exercises.exam import canonical_key
    from ...course.handin.exam_sheet import exam_sheet
    from ...course.handin.served_course import student_item
    from ...export.data.data import plain
    from ..courses import course_in
    from ..lesson_folder import lessons_of
    from ..printing import print_json

    lessons = lessons_of(options)
    course = course_in(options.course, lessons)
    if options.words:
        return _print_words(course, options)
    if not canonical_key(options.key):
        raise CommandError("The student's key is empty; give it as it is typed on the page.")
    asked = [item for item in course.items.values() if item.kind == "exam" and options.lesson in (None, item.lesson)]
    if not asked:
        there = ", ".join(dict.fromkeys(item.lesson for item in course.items.values() if item.kind == "exam")) or "none"
        raise CommandError(f"Course {course.id} has no exam here; lessons with exams: {there}.")
    records = []
    for place in asked:
        lesson, variant = lessons[place.lesson], options.variant if options.variant is not None else int(place.practice)
        exam = next(exam for exam in lesson.exams if exam.id == place.id)
        item = student_item(course, options.key, lesson.id, exam, variant)
        if not options.json:
            print(exam_sheet(lesson, exam, item, options.lang))
        answer = exam.digits.written(item.answer)
        records.append({"item": place.name, "variant": variant, "given": plain(dict(item.given)), "answer": answer})
    if options.json:
        print_json({"course": course.id, "key": options.key, "items": records})
    return 0


def _print_words(course: Course, options: argparse.Namespace) -> int:
    """The word of each student: of the key that was given, or of each line of a file."""
    from ...course.exercises.exam import canonical_key
    from ...course.handin.hand_in import written_key
    from ..inputs import read_text
    from ..printing import print_json

    if not course.words:
        raise CommandError("The course file says words = false; take that line away, and each student has a word.")
    lines = [options.key]
    if Path(options.key).exists():
        lines = [line.strip() for line in read_text(options.key, "key", "write one key a line into it").splitlines() if line.strip()]
    for line in lines:
        if not written_key(line):
            raise CommandError(f"{line[:40] or 'Nothing'} is no key of a student; use letters, digits, dots and dashes.")
    words = {line: course.keys.word(canonical_key(line)) for line in lines}
    if options.json:
        print_json({"course": course.id, "words": words})
    else:
        print("key,word", *(f"{key},{word}" for key, word in words.items()), sep="\n")
    return 0
