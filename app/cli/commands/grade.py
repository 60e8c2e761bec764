"""Grade the hand-ins of a course and write the tables that Moodle and Canvas import: `grade`."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..options import add_json, add_own_lessons

if TYPE_CHECKING:
    from ...course.handin.course_file import Course
    from ...course.handin.grading import Finding

HELP = "grade the hand-ins of a course; exit status 1 where some do not count"
SHOWN_CHARACTERS = 24  # of a token that does not count
UNBOUND = "the course file says words = false, so anybody can hand in under any key; say whose files they are by --folders or --map"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `grade`."""
    parser.add_argument("tokens", nargs="+", metavar="TOKENS", help="hand-ins, files that hold some, or folders of such files")
    parser.add_argument("--course", required=True, metavar="FILE", help="the course file")
    owners = parser.add_mutually_exclusive_group()
    owners.add_argument("--folders", action="store_true", help="count a hand-in only in a folder with the student's key for its name")
    owners.add_argument("--map", metavar="FILE", help="count it only where this CSV file says: name of a folder or file, student's key")
    parser.add_argument("-o", "--output", metavar="FILE", help="the table for Moodle; the one for Canvas is written beside it, with "
                                                               "-canvas in its name")
    add_own_lessons(parser)
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Judge every hand-in, name those that do not count, write the tables. Raises CommandError."""
    from ...course.handin.grading import best_points, canvas_table, grade, moodle_table, sources_of_students
    from ..courses import course_in, tokens_in
    from ..hand_in_places import HandInPlaces
    from ..lesson_folder import lessons_of
    from ..outputs import save_bytes, write_whole_file
    from ..printing import print_json

    lessons = lessons_of(options)
    course = course_in(options.course, lessons)
    places = HandInPlaces.of(options.tokens, options.folders, options.map)
    findings = grade(course, lessons, tokens_in(options.tokens), places.stranger)
    points = best_points(course, findings)
    warnings = tuple(_warnings(course, sources_of_students(findings, places.place), options.folders or options.map is not None))
    written = []
    if options.output is not None:
        path = Path(options.output)
        for table, place in ((moodle_table, path), (canvas_table, path.with_name(f"{path.stem}-canvas{path.suffix}"))):
            write_whole_file(str(place), partial(save_bytes, table(course, points).encode()))
            written.append(str(place))
    if options.json:
        print_json({"course": course.id, "points": points, "files": written, "warnings": list(warnings),
                    "hand_ins": [_record(one) for one in findings]})
    else:
        _tell(findings, len(points), warnings, written)
    return 1 if any(one.refusal is not None for one in findings) else 0


def _warnings(course: Course, several: Mapping[str, Sequence[str]], bound: bool) -> Iterator[str]:
    for student, places in several.items():
        yield f"hand-ins of {student} come from {len(places)} places: {', '.join(_printable(place) for place in places)}"
    if not course.words and not bound:
        yield UNBOUND


def _tell(findings: tuple[Finding, ...], students: int, warnings: Sequence[str], written: list[str]) -> None:
    kinds = Counter(str(one.refusal) for one in findings if one.refusal is not None)
    left = f"; not counted: {', '.join(f'{count} {kind}' for kind, count in kinds.items())}" if kinds else ""
    print(f"hand-ins: {len(findings)}, counted: {len(findings) - kinds.total()}, students: {students}{left}")
    for one in findings:
        who = f"{one.hand_in.student}, {one.hand_in.item}" if one.hand_in else ascii(one.token[:SHOWN_CHARACTERS])[1:-1] or "nothing"
        what = f"{one.points:g} points" if one.refusal is None else one.why
        print(f"  {one.refusal or 'counts'}: {who} ({_printable(one.source)}): {what}")
    for words in warnings:
        print(f"warning: {words}")
    for place in written:
        print(f"wrote {place}")


def _printable(words: str) -> str:
    """The name of a file without what would command a terminal."""
    return "".join(letter if letter.isprintable() else "?" for letter in words)


def _record(one: Finding) -> dict[str, object]:
    hand_in = one.hand_in
    return {"source": one.source, "verdict": one.refusal or "counts", "why": one.why, "points": one.points,
            "student": hand_in and hand_in.student, "item": hand_in and hand_in.item, "answer": hand_in and hand_in.answer,
            "time": hand_in and hand_in.time.isoformat()}
