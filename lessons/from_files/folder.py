"""Load the lessons of a folder, and those again whose files have changed."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from observer_lab.course.lesson import Lesson
from observer_lab.course.reading.toml_table import LessonFileError, refusal
from observer_lab.text import text

from .read_lesson import TOML, broken_lesson, read_lesson

ID = re.compile(r"[a-z0-9]{1,30}(-[a-z0-9]{1,30}){0,4}")
NOT_READ = text("The files of this lesson cannot be read; the log of the server says why.")
Stamp = tuple[tuple[str, int, int], ...]  # name, time and size of every file of a lesson

log = logging.getLogger(__name__)


@dataclass(eq=False)
class LessonFolder:
    """The lessons below a folder, one in each subfolder with a `lesson.toml`; `taken` are ids that are not free.

    Words of `uploaded` lessons may hold no HTML.
    """

    path: Path
    taken: tuple[str, ...]
    trusted: bool
    uploaded: bool = False
    _stamps: dict[str, Stamp] = field(default_factory=dict)
    _lessons: dict[str, Lesson] = field(default_factory=dict)

    def lessons(self) -> dict[str, Lesson]:
        """Every lesson by its id, in the order of the folders' names; changed ones are read anew."""
        return {lesson.id: lesson for lesson in self.read_each()}

    def read_each(self) -> Iterator[Lesson]:
        """Every lesson in that order, read when it is asked for."""
        for number, place in enumerate(self._places(), len(self.taken) + 1):
            stamp = _stamp_of(place)
            if stamp != self._stamps.get(place.name):
                self._lessons[place.name], self._stamps[place.name] = self._read(place, number), stamp
            yield self._lessons[place.name]

    def count(self) -> int:
        """How many lessons it holds, whole or not."""
        return len(self._places())

    def changed(self) -> bool:
        """Whether a file has changed since the lessons were read last."""
        places = self._places()
        return any(_stamp_of(place) != self._stamps.get(place.name) for place in places) or (
            {place.name for place in places} != set(self._stamps))

    def _places(self) -> list[Path]:
        found = sorted(path.parent for path in self.path.glob(f"*/{TOML}"))
        for name in set(self._stamps) - {place.name for place in found}:
            del self._stamps[name], self._lessons[name]
        return found

    def _read(self, place: Path, number: int) -> Lesson:
        try:
            if not ID.fullmatch(place.name):
                raise refusal(place.name[:40], 1, text("Name the folder with small letters, digits and hyphens."))
            if place.name in self.taken:
                raise refusal(place.name, 1, text("There is a lesson of this name already; rename the folder."))
            return read_lesson(place, number, self.trusted, self.uploaded)
        except LessonFileError as problem:
            id = re.sub(r"[^a-z0-9-]", "-", place.name.lower())[:30]
            return broken_lesson(f"{id}-broken" if id in self.taken else id, number, problem.text)
        except Exception:  # whatever one lesson brings, the others are read
            log.exception("lesson %s cannot be read", place.name)
            return broken_lesson(re.sub(r"[^a-z0-9-]", "-", f"{place.name.lower()[:20]}-broken"), number, NOT_READ)


def _stamp_of(place: Path) -> Stamp:
    found = []
    for path in sorted(_files(place)):
        try:
            known = path.stat()
        except OSError:  # removed meanwhile
            continue
        found.append((path.name, known.st_mtime_ns, known.st_size))
    return tuple(found)


def _files(place: Path) -> Iterable[Path]:
    try:
        return [path for path in place.iterdir() if path.is_file()]
    except OSError:  # removed meanwhile, or nobody may read it
        return ()
