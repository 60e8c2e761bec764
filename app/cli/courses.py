"""Read course files and hand-ins from files, and give a course the clock of this machine."""

from __future__ import annotations

import atexit
import os
import re
import shutil
import sqlite3
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from observer_lab.lessons import LESSONS

from ..course.handin.course_file import Course, CourseFileError, read_course
from ..course.handin.hand_in import MAX_TOKEN_CHARACTERS, PREFIX
from ..course.handin.ledger import KeptHandIns, Ledger
from ..course.handin.served_course import ServedCourse
from ..course.lesson import Lesson
from .inputs import read_text
from .options import CommandError, error_cause

WORD = re.compile(r"[^\s<>\"',;()]+")
MIN_TOKEN_CHARACTERS = 40  # a word of a file that is as long, and no address, is taken for a hand-in that lost its beginning


def course_in(name: str, lessons: Mapping[str, Lesson] = LESSONS, seen: Callable[[Path], object] = lambda path: None) -> Course:
    """The course of a file, with the secret that it holds or names in a file, which `seen` is told. Raises CommandError."""
    beside = Path(name).parent

    def read_secret(file: str) -> str:
        seen(beside / file)
        return read_text(str(beside / file), "secret", "write the secret of the course into it, as `openssl rand -hex 32` draws one")

    try:
        return read_course(read_text(name, "course", "give a course file; README.md shows one"), lessons, read_secret)
    except CourseFileError as problem:
        raise CommandError(f"The course file {name[:80]} cannot be used: {problem}.") from problem


def warn_if_open(path: Path) -> None:
    """Say on stderr that a file with a secret can be read by others of this machine."""
    if os.name == "posix" and path.is_file() and path.stat().st_mode & 0o077:
        print(f"observer-lab: {str(path)[:80]} can be read by other users of this machine; run chmod 600 on it.", file=sys.stderr)


def served_course(name: str, ledger: KeptHandIns, lessons: Mapping[str, Lesson]) -> ServedCourse:
    """The course of a file for a server. Hand-ins bear the time of this machine: it must be right."""
    secrets = list[Path]()
    course = course_in(name, lessons, secrets.append)
    for secret in secrets:
        warn_if_open(secret)
    return ServedCourse(course, now, ledger)


def open_ledger(data_dir: str | None, store: str | None = None) -> KeptHandIns:
    """What keeps hand-ins: a Redis server, the folder, or one that goes with this process. Raises CommandError."""
    if store is not None:
        from ..classroom.redis_connection import RoomProblem
        from ..page.lti.redis_ledger import RedisLedger

        try:
            return RedisLedger(store)
        except RoomProblem as problem:
            raise CommandError(str(problem)) from problem
    folder = Path(data_dir or tempfile.mkdtemp(prefix="observer-lab-course-"))
    if data_dir is None:
        atexit.register(shutil.rmtree, folder, ignore_errors=True)  # a worker ends without it
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return Ledger(folder)
    except (OSError, sqlite3.Error) as problem:
        cause = error_cause(problem) if isinstance(problem, OSError) else str(problem)
        raise CommandError(f"{str(folder)[:80]} cannot hold the hand-ins ({cause}); choose another folder.") from problem


def now() -> float:
    """The time of this machine, in seconds since 1970."""
    return time.time()


def tokens_in(given: Sequence[str]) -> Iterator[tuple[str, str]]:
    """(where it was found, token) for each hand-in: given as such, in a file, or in the files of a folder. Raises CommandError."""
    for word in given:
        if word.casefold().startswith(f"{PREFIX}."):
            yield "command line", word
        elif Path(word).is_dir():
            for path in sorted(file for file in Path(word).rglob("*") if file.is_file()):
                yield from _tokens_of_any(str(path))
        else:
            yield from _tokens_of(word)


def _tokens_of_any(name: str) -> Iterator[tuple[str, str]]:
    """Those of a file that somebody uploaded: one that is no text must not end the grading of all others."""
    try:
        yield from _tokens_of(name)
    except CommandError:
        yield name, ""


def _tokens_of(name: str) -> Iterator[tuple[str, str]]:
    content = read_text(name, "hand-in", "give a hand-in, a file or a folder of files")
    words = [word for word in WORD.findall(content) if _may_be_token(word)]
    if not words:
        yield name, ""
    for word in words:
        yield name, word[:MAX_TOKEN_CHARACTERS + 1]


def _may_be_token(word: str) -> bool:
    return word.casefold().startswith(f"{PREFIX}.") or (len(word) >= MIN_TOKEN_CHARACTERS and "/" not in word)
