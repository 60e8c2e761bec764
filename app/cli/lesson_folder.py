"""Open the folder of lessons that `serve` was given, and follow its files while the server runs."""

from __future__ import annotations

import argparse
import logging
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from .options import CommandError

if TYPE_CHECKING:
    from observer_lab.lessons.from_files.folder import LessonFolder

    from ..course.lesson import Lesson

log = logging.getLogger(__name__)
LOOK_INTERVAL_S = 0.5  # s between two looks at the files


def open_folder(name: str, taken: Iterable[str], trusted: bool) -> LessonFolder:
    """The folder with its lessons. What is wrong with one is said on stderr. Raises CommandError where there is none."""
    from observer_lab.lessons.from_files.folder import LessonFolder

    path = home_of(name)
    if not path.is_dir():
        raise CommandError(f"There is no folder {name[:80]}; give one that holds a folder for each lesson, or a .zip of it.")
    folder = LessonFolder(path, tuple(taken), trusted)
    lessons = folder.lessons()
    if not lessons:
        raise CommandError(f"The folder {name[:80]} holds no lesson; write one with observer-lab new-lesson NAME --folder {name[:80]}.")
    for id, lesson in lessons.items():
        _report(id, lesson)
    return folder


def lessons_with(name: str | None, trusted: bool = False) -> dict[str, Lesson]:
    """The lessons of the course, and those of a folder where one is named. Raises CommandError."""
    from observer_lab.lessons import all_lessons

    course = all_lessons()
    return dict(course) if name is None else {**course, **open_folder(name, course, trusted).lessons()}


def home_of(name: str) -> Path:
    """The folder of that name, or that of a .zip, unpacked. Raises CommandError."""
    from observer_lab.lessons.from_files.packed import PackError, unpacked

    try:
        return unpacked(Path(name)) if Path(name).is_file() else Path(name)
    except PackError as problem:
        raise CommandError(str(problem)) from problem


def lessons_of(options: argparse.Namespace) -> dict[str, Lesson]:
    """The lessons that a command may name: those of the course, and those of its --lessons. Raises CommandError."""
    if options.lessons is not None:
        options.lessons = str(home_of(options.lessons))
    return lessons_with(options.lessons, options.trust_code)


def first_whole(lessons: Mapping[str, Lesson]) -> str:
    """The first lesson that could be read, else the first."""
    return next((id for id, lesson in lessons.items() if not lesson.fault.id), next(iter(lessons)))


def _report(id: str, lesson: Lesson) -> None:
    if lesson.fault.id:
        print(f"observer-lab: lesson {id}: {lesson.fault('en')}", file=sys.stderr)


def follow_folder(folder: LessonFolder, replace_lessons: Callable[[Mapping[str, Lesson]], None], ended: Callable[[], bool]) -> None:
    """Look at the files on a thread of its own until `ended`, and hand the lessons on when a file has changed."""
    def look() -> None:
        while not ended():
            time.sleep(LOOK_INTERVAL_S)
            try:
                if folder.changed():
                    replace_lessons(folder.lessons())
            except Exception:  # a folder may vanish, and a file may change while it is read
                log.exception("the folder of lessons cannot be read")
    threading.Thread(target=look, name="observer-lab lessons", daemon=True).start()
