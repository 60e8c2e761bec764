"""Read a course file: which exams and tasks count, how often and until when, and its secret.

A course file is TOML. What stands at its head holds for every lesson; a lesson may say otherwise:

    course = "filtering-2026"
    title = "Filtering and identification"
    secret-file = "filtering-2026.secret"
    deadline = 2026-12-18T23:59:00+01:00
    tries = 2

    [[lessons]]
    lesson = "kalman"
    exams = ["sheet", "nis"]
    points = 5

    [[lessons]]
    lesson = "separation"
    exams = "all"
    tasks = "all"
    mode = "practice"
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from types import MappingProxyType
from typing import Annotated, Literal, NoReturn

from ...text import read_outside_toml
from ...text.schema import Checked, Misfit, judge, says, shown
from ..exercises.exam import Exam
from ..lesson import Lesson, Task
from .keys import CourseKeys

Kind = Literal["exam", "task"]
PER_LESSON = ("mode", "tries", "deadline", "points")  # what the head says for every lesson
MIN_SECRET_CHARACTERS = 20
MAX_TITLE_CHARACTERS, MAX_TRIES, MAX_POINTS = 120, 100, 100.0
TITLE = f"must be a text of 1 to {MAX_TITLE_CHARACTERS} characters"
Ids = Literal["all"] | list[str] | None


class _Rules(Checked, frozen=True):
    mode: Annotated[Literal["withheld", "practice"] | None, says('must be "withheld" or "practice"; it is {value}')] = None
    tries: Annotated[int, says(f"must be a whole number from 1 to {MAX_TRIES}; it is {{value}}", ge=1, le=MAX_TRIES)] | None = None
    deadline: Annotated[datetime, says(
        "must be a date and time with its distance from UTC, as in 2026-12-18T23:59:00+01:00", tz=True)] | None = None
    points: Annotated[float, says(f"must be a positive number up to {MAX_POINTS:g}; it is {{value}}", gt=0, le=MAX_POINTS)] | None = None


class _Lesson(_Rules, frozen=True, kw_only=True):
    lesson: Annotated[str | None, says("names no lesson ({value}); use the id of one")] = None
    exams: Annotated[Ids, says('must be a list of exams, or "all"')] = None
    tasks: Annotated[Ids, says('must be a list of tasks, or "all"')] = None


class _Head(_Rules, frozen=True, kw_only=True):
    course: Annotated[str, says("must be a name of at most 60 letters, digits, dots, dashes and underscores",
                                pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,59}\Z")]
    title: Annotated[str, says(TITLE, min_length=1, max_length=MAX_TITLE_CHARACTERS)] | None = None
    secret: Annotated[str, says("must be a text", min_length=1)] | None = None
    secret_file: Annotated[str, says("must be a text", min_length=1)] | None = None
    words: Annotated[bool, says("must be true or false; with true each student types a word, which variant --words prints")] = True
    lessons: Annotated[list[Annotated[_Lesson, says("must be tables, each under [[lessons]]")]],
                       says("is missing; write each lesson under [[lessons]]", min_length=1)]


class CourseFileError(ValueError):
    """A course file that cannot be used; the message says in one sentence where and why. It never holds the secret."""


@dataclass(frozen=True)
class CourseItem:
    """One exam or task of a course. One that is withheld is handed in; one for practice shows results and solutions at once."""

    kind: Kind
    lesson: str
    id: str
    practice: bool = False
    tries: int = 1  # so many hand-ins of a student count, the best of them
    deadline: datetime | None = None
    points: float = 1.0

    @property
    def name(self) -> str:
        """Its name in seeds, hand-ins and lists of grades."""
        return item_name(self.kind, self.lesson, self.id)


@dataclass(frozen=True, eq=False)
class Course:
    """A course: its items by name, and the keys that its secret gives.

    With `words`, the server signs for a typed key only beside the word that belongs to it.
    """

    id: str
    title: str
    items: Mapping[str, CourseItem]
    keys: CourseKeys
    words: bool = True

    def item(self, kind: Kind, lesson: str, id: str) -> CourseItem | None:
        """That exam or task, None where the course does not name it."""
        return self.items.get(item_name(kind, lesson, id))


def item_name(kind: Kind, lesson: str, id: str) -> str:
    """The name of an exam or a task, whatever course it belongs to."""
    return f"{lesson} {kind} {id}"


def read_course(content: str, lessons: Mapping[str, Lesson], read_secret: Callable[[str], str]) -> Course:
    """The course of a TOML text; `read_secret` reads the file that the text names. Raises CourseFileError."""
    try:
        head = judge(read_outside_toml(content), _Head, "is no key of a course file; use {keys}")
    except tomllib.TOMLDecodeError as problem:
        raise CourseFileError(f"it is not valid TOML: {str(problem)[:120]}") from problem
    except Misfit as problem:
        _refuse(f"lesson {problem.place[1] + 1}, " if problem.place[1:] else "", problem.key, problem.words)  # type: ignore[operator]
    items: dict[str, CourseItem] = {}
    for number, table in enumerate(head.lessons, 1):
        for item in _items(table, f"lesson {number}, ", head, lessons):
            if item.name in items:
                _refuse(f"lesson {number}, ", f"{item.kind}s", f"names {item.id} of {item.lesson} a second time")
            items[item.name] = item
    title = (head.course if head.title is None else head.title).strip()
    if not title:
        _refuse("", "title", TITLE)
    return Course(head.course, title, MappingProxyType(items), CourseKeys.of(head.course, _secret(head, read_secret)), head.words)


def _items(table: _Lesson, where: str, head: _Head, lessons: Mapping[str, Lesson]) -> Iterator[CourseItem]:
    lesson = lessons.get(table.lesson or "")
    if lesson is None:
        _refuse(where, "lesson", f"names no lesson ({shown(table.lesson)}); use one of {', '.join(lessons)}")
    mode, tries, deadline, points = (getattr(head if getattr(table, key) is None else table, key) for key in PER_LESSON)
    if table.exams is None and table.tasks is None:
        _refuse(where, "exams", 'and tasks are missing; name some, or write exams = "all"')
    asked: tuple[tuple[Kind, str, Ids, Sequence[Exam | Task]], ...] = (
        ("exam", "exams", table.exams, lesson.exams), ("task", "tasks", table.tasks, lesson.tasks))
    for kind, key, named, there in asked:
        for id in _ids(named or [], tuple(each.id for each in there), where, key):
            yield CourseItem(kind, lesson.id, id, mode == "practice", tries or 1, deadline, float(points or 1.0))


def _ids(named: list[str] | str, there: tuple[str, ...], where: str, key: str) -> tuple[str, ...]:
    for id in () if named == "all" else named:
        if id not in there:
            _refuse(where, key, f"names {shown(id)}, which does not exist; use some of {', '.join(there) or '—'}")
    return there if named == "all" else tuple(named)


def _secret(head: _Head, read_secret: Callable[[str], str]) -> str:
    if (head.secret is None) == (head.secret_file is None):
        _refuse("", "secret", "or secret-file must be given, one of the two")
    secret = (head.secret if head.secret_file is None else read_secret(head.secret_file) or "").strip()  # type: ignore[union-attr]
    if len(secret) < MIN_SECRET_CHARACTERS:
        _refuse("", "secret-file" if head.secret is None else "secret",
                f"must hold at least {MIN_SECRET_CHARACTERS} characters; `openssl rand -hex 32` draws a good secret")
    return secret


def _refuse(where: str, key: str, what: str) -> NoReturn:
    raise CourseFileError(f"{where}{key} {what}")
