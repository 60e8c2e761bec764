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

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from types import MappingProxyType
from typing import Literal, NoReturn

from ..lesson import Lesson
from .keys import CourseKeys

Kind = Literal["exam", "task"]
PER_LESSON = ("mode", "tries", "deadline", "points")
HEAD_KEYS = ("course", "title", "secret", "secret-file", *PER_LESSON, "lessons")
LESSON_KEYS = ("lesson", "exams", "tasks", *PER_LESSON)
MODES = ("withheld", "practice")
COURSE_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,59}", re.ASCII)
MIN_SECRET_CHARACTERS = 20
MAX_TITLE_CHARACTERS, MAX_SHOWN_CHARACTERS = 120, 40
MAX_TRIES, MAX_POINTS = 100, 100.0


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
    """A course: its items by name, and the keys that its secret gives."""

    id: str
    title: str
    items: Mapping[str, CourseItem]
    keys: CourseKeys

    def item(self, kind: Kind, lesson: str, id: str) -> CourseItem | None:
        """That exam or task, None where the course does not name it."""
        return self.items.get(item_name(kind, lesson, id))


def item_name(kind: Kind, lesson: str, id: str) -> str:
    """The name of an exam or a task, whatever course it belongs to."""
    return f"{lesson} {kind} {id}"


def read_course(words: str, lessons: Mapping[str, Lesson], read_secret: Callable[[str], str]) -> Course:
    """The course of a TOML text; `read_secret` reads the file that the text names. Raises CourseFileError."""
    try:
        data = tomllib.loads(words)
    except tomllib.TOMLDecodeError as problem:
        raise CourseFileError(f"it is not valid TOML: {str(problem)[:120]}") from problem
    _check_keys(data, HEAD_KEYS, "")
    id = data.get("course")
    if not isinstance(id, str) or COURSE_ID.fullmatch(id) is None:
        _refuse("", "course", "must be a name of at most 60 letters, digits, dots, dashes and underscores")
    title = data.get("title", id)
    if not isinstance(title, str) or not 0 < len(title.strip()) <= MAX_TITLE_CHARACTERS:
        _refuse("", "title", f"must be a text of 1 to {MAX_TITLE_CHARACTERS} characters")
    tables = data.get("lessons")
    if not isinstance(tables, list) or not tables:
        _refuse("", "lessons", "is missing; write each lesson under [[lessons]]")
    items: dict[str, CourseItem] = {}
    for number, table in enumerate(tables, 1):
        for item in _items(table, f"lesson {number}, ", data, lessons):
            if item.name in items:
                _refuse(f"lesson {number}, ", f"{item.kind}s", f"names {item.id} of {item.lesson} a second time")
            items[item.name] = item
    return Course(id, title.strip(), MappingProxyType(items), CourseKeys.of(id, _secret(data, read_secret)))


def _items(table: object, where: str, head: Mapping[str, object], lessons: Mapping[str, Lesson]) -> Iterator[CourseItem]:
    if not isinstance(table, dict):
        _refuse("", "lessons", "must be tables, each under [[lessons]]")
    _check_keys(table, LESSON_KEYS, where)
    lesson = lessons.get(name) if isinstance(name := table.get("lesson"), str) else None
    if lesson is None:
        _refuse(where, "lesson", f"names no lesson ({_short(name)}); use one of {', '.join(lessons)}")
    said = {key: (table.get(key, head.get(key)), where if key in table else "") for key in PER_LESSON}
    practice, tries, deadline, points = _mode(*said["mode"]), _tries(*said["tries"]), _deadline(*said["deadline"]), _points(*said["points"])
    if "exams" not in table and "tasks" not in table:
        _refuse(where, "exams", 'and tasks are missing; name some, or write exams = "all"')
    for id in _ids(table.get("exams", []), tuple(exam.id for exam in lesson.exams), where, "exams"):
        yield CourseItem("exam", lesson.id, id, practice, tries, deadline, points)
    for id in _ids(table.get("tasks", []), tuple(task.id for task in lesson.tasks), where, "tasks"):
        yield CourseItem("task", lesson.id, id, practice, tries, deadline, points)


def _ids(value: object, there: tuple[str, ...], where: str, key: str) -> tuple[str, ...]:
    if value == "all":
        return there
    if not isinstance(value, list):
        _refuse(where, key, f'must be a list of {key}, or "all"')
    for id in value:
        if id not in there:
            _refuse(where, key, f"names {_short(id)}, which does not exist; use some of {', '.join(there) or '—'}")
    return tuple(value)


def _mode(value: object, where: str) -> bool:
    if value is not None and value not in MODES:
        _refuse(where, "mode", f'must be "withheld" or "practice"; it is {_short(value)}')
    return value == "practice"


def _tries(value: object, where: str) -> int:
    if value is None:
        return 1
    if type(value) is not int or not 1 <= value <= MAX_TRIES:
        _refuse(where, "tries", f"must be a whole number from 1 to {MAX_TRIES}; it is {_short(value)}")
    return value


def _deadline(value: object, where: str) -> datetime | None:
    if value is not None and not (isinstance(value, datetime) and value.tzinfo is not None):
        _refuse(where, "deadline", "must be a date and time with its distance from UTC, as in 2026-12-18T23:59:00+01:00")
    return value


def _points(value: object, where: str) -> float:
    if value is None:
        return 1.0
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value <= MAX_POINTS:
        _refuse(where, "points", f"must be a positive number up to {MAX_POINTS:g}; it is {_short(value)}")
    return float(value)


def _secret(data: Mapping[str, object], read_secret: Callable[[str], str]) -> str:
    if ("secret" in data) == ("secret-file" in data):
        _refuse("", "secret", "or secret-file must be given, one of the two")
    key = "secret" if "secret" in data else "secret-file"
    value = data[key]
    if not isinstance(value, str) or not value:
        _refuse("", key, "must be a text")
    secret = (value if key == "secret" else read_secret(value)).strip()
    if len(secret) < MIN_SECRET_CHARACTERS:
        _refuse("", key, f"must hold at least {MIN_SECRET_CHARACTERS} characters; `openssl rand -hex 32` draws a good secret")
    return secret


def _check_keys(table: Mapping[str, object], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            _refuse(where, _short(key), f"is no key of a course file; use {', '.join(known)}")


def _refuse(where: str, key: str, what: str) -> NoReturn:
    raise CourseFileError(f"{where}{key} {what}")


def _short(value: object) -> str:
    """What a file says, as it is quoted in an error."""
    return str(value)[:MAX_SHOWN_CHARACTERS] or "—"
