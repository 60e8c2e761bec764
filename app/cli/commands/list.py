"""List the lessons, their knobs and tasks, and write lessons of one's own as one file: `list`."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

from ..options import CommandError, add_json, add_own_lessons

HELP = "lessons, their knobs and tasks"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `list`."""
    add_own_lessons(parser)
    parser.add_argument("--zip", metavar="FILE.zip", help="write the lessons of --lessons FOLDER as one file to give to colleagues")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print every lesson. Raises CommandError where lessons cannot be packed."""
    from observer_lab.lessons.from_files.packed import PackError, pack

    from ..lesson_folder import lessons_of
    from ..outputs import write_whole_file
    from ..printing import lesson_record, print_json, print_lesson

    packing = options.zip is not None and options.lessons is not None and Path(options.lessons).is_dir()
    lessons = lessons_of(options)
    if options.zip is not None:
        if not packing:
            raise CommandError("Give --lessons FOLDER with --zip: the folder whose lessons it packs.")
        broken = [id for id, lesson in lessons.items() if lesson.fault.id]
        if broken:
            raise CommandError(f"Lesson {broken[0]} cannot be read; correct it before you pack.")
        try:
            write_whole_file(options.zip, partial(pack, Path(options.lessons)))
        except PackError as problem:
            raise CommandError(str(problem)) from problem
        print(options.zip)
        return 0
    if options.json:
        print_json([lesson_record(lesson) for lesson in lessons.values()])
        return 0
    for lesson in lessons.values():
        print_lesson(lesson)
    return 0
