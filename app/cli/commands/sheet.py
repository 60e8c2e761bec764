"""Print a problem sheet of lessons or of a course as PDF, and its solutions apart: `sheet`."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ...text.languages import languages
from ..options import CommandError, add_own_lessons, whole_number

if TYPE_CHECKING:
    from ...course.exercises.exam import Exam, ExamItem
    from ...course.lesson import Lesson

HELP = "a problem sheet as PDF from the exams of lessons or of a course, with the numbers of a key, and its solutions apart"
MAX_VARIANT = 10**6


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `sheet`."""
    parser.add_argument("lessons_asked", nargs="*", metavar="LESSON", help="lessons whose exams are asked; see list")
    parser.add_argument("--course", metavar="NAME|FILE",
                        help="all exams of a course of the lab (first, estimation, platform), or those that a course file names")
    parser.add_argument("--key", default="sheet", help="whose numbers: a student's key or any word (default: sheet)")
    parser.add_argument("--variant", type=whole_number(0, MAX_VARIANT, "is no variant; give a whole number"), default=1, metavar="N",
                        help="which variant of the numbers (default: 1)")
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the sheet")
    add_own_lessons(parser)
    parser.add_argument("-o", "--output", required=True, metavar="FILE.pdf", help="the sheet with lines for answers")
    parser.add_argument("--solutions", metavar="FILE.pdf", help="answers and derivations, in a file of their own")


def execute(options: argparse.Namespace) -> int:
    """Write one file or two. Raises CommandError where nothing is asked, or at another suffix."""
    from ...course.handin.exam_sheet import exam_parts
    from ...export.sheet.sheet import Problem, problem_sheet
    from ..outputs import write_whole_file

    files = [(options.output, False), *([(options.solutions, True)] if options.solutions else [])]
    for file, _ in files:
        if Path(file).suffix.lower() != ".pdf":
            raise CommandError(f"A sheet is a PDF; {Path(file).name[:40]} does not end in .pdf.")
    asked = list(_asked(options))
    if not asked:
        raise CommandError("There is no exam to print; name lessons that have exams, or a course with --course.")
    problems = [Problem(*exam_parts(lesson, exam, item, options.lang)) for lesson, exam, item in asked]
    titles = list(dict.fromkeys(lesson.words[options.lang].title for lesson, _, _ in asked))
    title = " · ".join(titles[:3]) + (" …" if len(titles) > 3 else "")
    for file, solved in files:
        content = problem_sheet(title, f"{options.key} · {options.variant}", problems, solved, options.lang)
        write_whole_file(file, lambda name, content=content: Path(name).write_bytes(content))
    return 0


def _asked(options: argparse.Namespace) -> Iterator[tuple[Lesson, Exam, ExamItem]]:
    """The exams with their numbers, in the order of the course or of the lessons. Raises CommandError."""
    from ...course.exercises.exam import seed_of
    from ...course.handin.served_course import student_item
    from ..courses import course_in
    from ..lesson_folder import lessons_of

    lessons = lessons_of(options)
    for name in options.lessons_asked:
        if name not in lessons:
            raise CommandError(f"There is no lesson {name[:40]}; there are {', '.join(lessons)}.")
    asked = options.lessons_asked
    if options.course and (found := _course_of_the_lab(options.course, lessons)):
        asked = [name for name in found if not asked or name in asked]
    elif options.course:
        course = course_in(options.course, lessons)
        for place in course.items.values():
            if place.kind == "exam" and (not options.lessons_asked or place.lesson in options.lessons_asked):
                lesson = lessons[place.lesson]
                exam = next(exam for exam in lesson.exams if exam.id == place.id)
                yield lesson, exam, student_item(course, options.key, lesson.id, exam, options.variant)
        return
    for lesson in (lessons[name] for name in asked):
        for exam in lesson.exams:
            yield lesson, exam, exam.item(seed_of(options.key, lesson.id, exam.id, options.variant))


def _course_of_the_lab(name: str, lessons: Mapping[str, Lesson]) -> list[str]:
    """The lessons of a course that the lab has itself, none where the name is that of a file. Raises CommandError."""
    from ...course.course_map import LEARNING_PATHS

    if Path(name).exists() or Path(name).suffix or len(Path(name).parts) > 1:
        return []
    if name not in LEARNING_PATHS:
        raise CommandError(f"There is no course {name[:40]}; there are {', '.join(LEARNING_PATHS)}. Or give a course file, NAME.toml.")
    return [id for id, lesson in lessons.items() if LEARNING_PATHS[name] in lesson.place.ways]
