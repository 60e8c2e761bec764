"""Grade the hand-ins of a course and write the tables that Moodle and Canvas import: `grade`."""

from __future__ import annotations

import argparse
from collections import Counter
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..options import add_json

if TYPE_CHECKING:
    from ...course.handin.grading import Finding

HELP = "grade the hand-ins of a course; exit status 1 where some do not count"
SHOWN_CHARACTERS = 24  # of a token that does not count


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `grade`."""
    parser.add_argument("tokens", nargs="+", metavar="TOKENS", help="hand-ins, files that hold some, or folders of such files")
    parser.add_argument("--course", required=True, metavar="FILE", help="the course file")
    parser.add_argument("-o", "--output", metavar="FILE", help="the table for Moodle; the one for Canvas is written beside it, with "
                                                               "-canvas in its name")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Judge every hand-in, name those that do not count, write the tables. Raises CommandError."""
    from observer_lab.lessons import LESSONS

    from ...course.handin.gradebooks import canvas_table, moodle_table
    from ...course.handin.grading import best_points, grade
    from ..courses import course_in, tokens_in
    from ..outputs import save_bytes, write_whole_file
    from ..printing import print_json

    course = course_in(options.course)
    findings = grade(course, LESSONS, tokens_in(options.tokens))
    points = best_points(course, findings)
    written = []
    if options.output is not None:
        path = Path(options.output)
        for table, place in ((moodle_table, path), (canvas_table, path.with_name(f"{path.stem}-canvas{path.suffix}"))):
            write_whole_file(str(place), partial(save_bytes, table(course, points).encode()))
            written.append(str(place))
    refused = [one for one in findings if one.refusal is not None]
    if options.json:
        print_json({"course": course.id, "points": points, "files": written, "hand_ins": [_record(one) for one in findings]})
    else:
        _tell(findings, refused, len(points), written)
    return 1 if refused else 0


def _tell(findings: tuple[Finding, ...], refused: list[Finding], students: int, written: list[str]) -> None:
    kinds = Counter(str(one.refusal) for one in refused)
    left = f"; not counted: {', '.join(f'{count} {kind}' for kind, count in kinds.items())}" if kinds else ""
    print(f"hand-ins: {len(findings)}, counted: {len(findings) - len(refused)}, students: {students}{left}")
    for one in refused:
        who = f"{one.hand_in.student}, {one.hand_in.item}" if one.hand_in else ascii(one.token[:SHOWN_CHARACTERS])[1:-1] or "nothing"
        print(f"  {one.refusal}: {who} ({_printable(one.source)}): {one.why}")
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
