"""Print the teacher's notes of a lesson: `teach`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ...text import text
from ...text.languages import languages
from ..options import add_own_lessons

HELP = "notes for the teacher of a lesson, and its terms"
TERMS = text("Terms of this lesson")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `teach`."""
    parser.add_argument("lesson", metavar="LESSON", help="a lesson's name; see list")
    add_own_lessons(parser)
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the notes; English where it has none")


def execute(options: argparse.Namespace) -> int:
    """Print the notes and the terms in Markdown. Raises CommandError at a lesson that there is not."""
    from observer_lab.lessons import all_lessons, folder, glossaries

    from ...course.prose import read_notes
    from ...course.sentences import prose_parts
    from ..inputs import find_lesson
    from ..lesson_folder import lessons_of
    from .glossary import in_markdown

    lessons = lessons_of(options)
    lesson = find_lesson(options.lesson, lessons)
    used = glossaries()[options.lang].used(
        words for where, words in prose_parts(lesson.words[options.lang]) if not where.startswith("reference"))
    place = folder(lesson.id) if lesson.id in all_lessons() else Path(options.lessons) / lesson.id
    if (place / "teacher.md").is_file():
        print(read_notes(place, options.lang), end="")
    else:
        print(f"observer-lab: lesson {lesson.id} has no notes; write teacher.md beside its lesson.toml.", file=sys.stderr)
    print(f"## {TERMS(options.lang)}\n{in_markdown(used)}")
    return 0
