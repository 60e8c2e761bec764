"""Print the teacher's notes of a lesson: `teach`."""

from __future__ import annotations

import argparse

from ...text import text
from ...text.languages import languages

HELP = "notes for the teacher of a lesson, and its terms"
TERMS = text("Terms of this lesson")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `teach`."""
    parser.add_argument("lesson", metavar="LESSON", help="a lesson's name; see list")
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the notes; English where it has none")


def execute(options: argparse.Namespace) -> int:
    """Print the notes and the terms in Markdown. Raises CommandError at a lesson that there is not."""
    from observer_lab.lessons import folder, glossaries

    from ...course.prose import read_notes
    from ...course.sentences import prose_parts
    from ..inputs import find_lesson
    from .glossary import in_markdown

    lesson = find_lesson(options.lesson)
    used = glossaries()[options.lang].used(
        words for where, words in prose_parts(lesson.words[options.lang]) if not where.startswith("reference"))
    print(read_notes(folder(lesson.id), options.lang), end="")
    print(f"## {TERMS(options.lang)}\n{in_markdown(used)}")
    return 0
