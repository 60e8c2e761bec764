"""Write points as the tables that Moodle and Canvas import."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping

from .course_file import Course

Points = Mapping[str, Mapping[str, float]]  # student → item → points


def moodle_table(course: Course, points: Points) -> str:
    """The points as CSV for "Import CSV" of Moodle's gradebook; map "ID number" to the field that holds the students' keys.

    An item that was not handed in is "-", as Moodle writes no grade.
    """
    names = _asked(course)
    rows = [[student, *(f"{row[name]:g}" if name in row else "-" for name in names)] for student, row in points.items()]
    return _csv([["ID number", *names], *rows])


def canvas_table(course: Course, points: Points) -> str:
    """The points as CSV for "Import" of Canvas' gradebook, with the row of points possible.

    Canvas finds a student by SIS User ID or SIS Login ID; the key stands in both. What was not handed in stays blank.
    """
    names = _asked(course)
    head = ["Student", "ID", "SIS User ID", "SIS Login ID", "Section", *names]
    possible = ["Points Possible", "", "", "", "", *(f"{course.items[name].points:g}" for name in names)]
    rows = [[student, "", student, student, "", *(f"{row[name]:g}" if name in row else "" for name in names)]
            for student, row in points.items()]
    return _csv([head, possible, *rows])


def _asked(course: Course) -> list[str]:
    return [name for name, item in course.items.items() if not item.practice]


def _csv(rows: Iterable[list[str]]) -> str:
    out = io.StringIO()
    csv.writer(out).writerows(rows)
    return out.getvalue()
