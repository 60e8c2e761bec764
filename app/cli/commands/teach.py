"""Print the teacher's notes of a lesson: `teach`."""

from __future__ import annotations

import argparse

from ...text.languages import languages

HELP = "notes for the teacher of a lesson"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `teach`."""
    parser.add_argument("lesson", metavar="LESSON", help="a lesson's name; see list")
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the notes; English where it has none")


def execute(options: argparse.Namespace) -> int:
    """Print the notes as they are written, in Markdown. Raises CommandError at a lesson that there is not."""
    from observer_lab.lessons import folder

    from ...course.prose import read_notes
    from ..inputs import find_lesson

    print(read_notes(folder(find_lesson(options.lesson).id), options.lang), end="")
    return 0
