"""Grade hand-ins: verify each, judge its answer, and write tables for Moodle and Canvas."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from ..exercises.exam import canonical_key, number_of
from ..exercises.typed_answers import UnreadableInput
from ..lesson import Lesson
from .course_file import Course, CourseItem
from .hand_in import SOLVED, HandIn, HandInError, Refusal, read_hand_in
from .served_course import student_item

Points = Mapping[str, Mapping[str, float]]  # student → item → points


@dataclass(frozen=True)
class Finding:
    """What one token is worth: its points where it counts, else why it does not. `source` says where it was found."""

    source: str
    token: str
    hand_in: HandIn | None = None
    refusal: Refusal | None = None
    why: str = ""
    points: float = 0.0


def grade(course: Course, lessons: Mapping[str, Lesson], tokens: Iterable[tuple[str, str]],
          stranger: Callable[[str, str], str | None] = lambda source, student: None) -> tuple[Finding, ...]:
    """A finding for each (source, token), in the same order.

    Of a student's hand-ins of one item the first `tries` count, by the time of their signature; a late one uses up no try, nor does
    one that another student gave. `stranger` says of a source and a student why it is not theirs, None where it may be.
    """
    found = [_verified(course, source, token, stranger) for source, token in tokens]
    used: Counter[tuple[str, str]] = Counter()
    seen: set[str] = set()
    valid = [(one.hand_in.issued, place, one.hand_in) for place, one in enumerate(found) if one.hand_in is not None and one.refusal is None]
    for _, place, hand_in in sorted(valid, key=lambda one: one[:2]):
        found[place] = _counted(course, lessons, found[place], hand_in, seen, used)
    return tuple(found)


def best_points(course: Course, findings: Sequence[Finding]) -> dict[str, dict[str, float]]:
    """Student → item → points of the best hand-in that counts; students as they wrote their key first, in order."""
    spelled: dict[str, str] = {}
    marks: dict[str, dict[str, float]] = {}
    for one in findings:
        if one.hand_in is not None and one.refusal is None:
            student = spelled.setdefault(canonical_key(one.hand_in.student), one.hand_in.student)
            row = marks.setdefault(student, {})
            row[one.hand_in.item] = max(one.points, row.get(one.hand_in.item, 0.0))
    return {student: marks[student] for student in sorted(marks, key=canonical_key)}


def _verified(course: Course, source: str, token: str, stranger: Callable[[str, str], str | None]) -> Finding:
    """A finding whose signature, item, deadline and giver are judged, and not yet its answer nor how often it came."""
    try:
        hand_in = read_hand_in(course, token)
    except HandInError as problem:
        return Finding(source, token, None, problem.kind, str(problem))
    item = course.items.get(hand_in.item)
    if item is None or item.practice:
        return Finding(source, token, hand_in, Refusal.NOT_ASKED, f"the course file asks for no {hand_in.item}")
    if item.deadline is not None and hand_in.issued > item.deadline.timestamp():
        return Finding(source, token, hand_in, Refusal.LATE, f"it was signed at {hand_in.time:%Y-%m-%d %H:%M:%S} UTC, after "
                                                             f"{item.deadline.isoformat(' ', 'minutes')}")
    if (why := stranger(source, hand_in.student)) is not None:
        return Finding(source, token, hand_in, Refusal.OTHER_STUDENT, why)
    return Finding(source, token, hand_in)


def sources_of_students(findings: Sequence[Finding], place: Callable[[str], str]) -> dict[str, tuple[str, ...]]:
    """Student → the places of the hand-ins that count, where there are several; a place is what `place` makes of a source."""
    found: dict[str, dict[str, None]] = {}
    for one in findings:
        if one.hand_in is not None and one.refusal in (None, Refusal.DOUBLED):
            found.setdefault(canonical_key(one.hand_in.student), {})[place(one.source)] = None
    return {student: tuple(places) for student, places in found.items() if len(places) > 1}


def _counted(course: Course, lessons: Mapping[str, Lesson], one: Finding, hand_in: HandIn, seen: set[str],
             used: Counter[tuple[str, str]]) -> Finding:
    item, owner = course.items[hand_in.item], (canonical_key(hand_in.student), hand_in.item)
    if one.token in seen:
        return replace(one, refusal=Refusal.DOUBLED, why="the same hand-in was given before")
    seen.add(one.token)
    if used[owner] >= item.tries:
        return replace(one, refusal=Refusal.DOUBLED, why=f"the first {item.tries} of this student and item count already")
    used[owner] += 1
    return replace(one, points=item.points if _right(course, lessons[item.lesson], item, hand_in) else 0.0)


def _right(course: Course, lesson: Lesson, item: CourseItem, hand_in: HandIn) -> bool:
    """Whether the answer is right. A task was judged by the server, on the design that stood there, before it signed."""
    if item.kind == "task":
        return hand_in.answer == SOLVED
    exam = next(exam for exam in lesson.exams if exam.id == item.id)
    try:
        said = number_of(hand_in.answer)
    except UnreadableInput:
        return False
    return exam.digits.accepts(student_item(course, hand_in.student, lesson.id, exam).answer, said)


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
