"""List the lessons, their knobs and tasks: `list`."""

from __future__ import annotations

import argparse

from ..options import add_json

HELP = "lessons, their knobs and tasks"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `list`."""
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print every lesson."""
    from observer_lab.lessons import all_lessons

    from ..printing import lesson_record, print_json, print_lesson

    if options.json:
        print_json([lesson_record(lesson) for lesson in all_lessons().values()])
        return 0
    for lesson in all_lessons().values():
        print_lesson(lesson)
    return 0
