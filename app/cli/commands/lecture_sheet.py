"""Write what a lecture has shown on one sheet: `lecture-sheet`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ...text.languages import languages
from ..options import CommandError, add_own_lessons, error_cause

if TYPE_CHECKING:
    from ...classroom.votes import Vote

HELP = "one sheet after a lecture: votes before and after, and where people worked, by scene"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `lecture-sheet`."""
    parser.add_argument("room", metavar="FOLDER|redis://…", help="where serve --room has kept the room: its --data-dir or --room-store")
    parser.add_argument("-o", "--output", metavar="FILE", help="an .html page or a .csv table (default: print the table)")
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the sheet")
    add_own_lessons(parser)


def execute(options: argparse.Namespace) -> int:
    """Write or print the sheet. Raises CommandError where there is no room, or at another suffix."""
    from ...page.votes.lecture_sheet import sheet_csv, sheet_html, sheet_rows
    from ..lesson_folder import lessons_of
    from ..outputs import write_whole_file

    suffix = Path(options.output).suffix if options.output else ".csv"
    write = {".csv": sheet_csv, ".html": sheet_html}.get(suffix)
    if write is None:
        raise CommandError(f"{suffix[:20] or 'A file without a suffix'} is no form of the sheet; take .html or .csv.")
    votes, seen = _kept(options.room)
    lessons = lessons_of(options)
    for unknown in sorted({vote.lesson for vote in votes} - set(lessons)):
        print(f"observer-lab: the votes of lesson {unknown[:80]} are left out; give its folder by --lessons.", file=sys.stderr)
    words = write(sheet_rows(votes, seen, lessons, options.lang), lessons, options.lang)
    if options.output:
        write_whole_file(options.output, lambda name: Path(name).write_text(words, encoding="utf-8"))
    else:
        print(words, end="")
    return 0


def _kept(place: str) -> tuple[tuple[Vote, ...], dict[str, int]]:
    """The votes and the largest counts by place of the room that is kept there."""
    import sqlite3

    from ...classroom.kept_room import is_redis, open_room
    from ...classroom.redis_connection import RoomProblem
    from ...classroom.room_store import FILE

    if not is_redis(place) and not (Path(place) / FILE).is_file():
        raise CommandError(f"{place[:80]} holds no room; name the folder of serve --room --data-dir.")
    try:
        kept = open_room(place)
        try:
            return kept.votes(), kept.seen()
        finally:
            kept.close()
    except RoomProblem as problem:
        raise CommandError(str(problem)) from problem
    except (OSError, sqlite3.Error) as problem:
        raise CommandError(f"The room in {place[:80]} cannot be read ({error_cause(problem)}).") from problem
