"""Keep recorded lessons by what they were made from, so that each is recorded once."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from ..course.lesson import Lesson
from ..engine.kernels import kernels_off

MOST_KEPT = 4  # recordings of one lesson that are kept, the last used ones
UNSHOWN = ("cli", "live", "notebook", "page/record/published_page.py", "page/record/published_page.py", "page/record/published_page.py",
           "page/web/styles/published.css", "page/web/viser_page/published.js", "published", "static_pages/store.py",
           "study")  # parts of the package on which no recorded state depends
SHARED_BY_LESSONS = ("toolkit", "from_files")  # folders beside those of the lessons
LIBRARIES = ("viser", "numpy", "scipy", "control", "numba")
KEY = "key.txt"
Write = Callable[[str, str], object]  # the name of a file in a folder, and its text


def write_file(folder: Path, name: str, words: str) -> None:
    """Write a file of a folder."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(words, encoding="utf-8")


@dataclass(frozen=True)
class Sources:
    """The folders of the package and of its lessons, and where each lesson to be recorded stands."""

    package: Path
    course: Path
    places: Mapping[str, Path]

    def keys(self, lessons: Mapping[str, Lesson], languages: Iterable[str], *settings: object) -> dict[str, str]:
        """For each lesson, in one word, what its files depend on: its own sources, the shared ones, the libraries and the settings."""
        spoken = list(languages)
        shared = hashlib.sha256(repr((settings, [*map(_version, LIBRARIES), kernels_off()])).encode())
        _add(shared, self.package, self._shared())
        for root in (*self.course.glob("*.*"), *(self.course / name for name in SHARED_BY_LESSONS)):
            _add(shared, self.course, _files(root))
        for lesson in lessons.values():
            shared.update(repr(_on_other_pages(lesson, spoken)).encode())
        return {id: self._key(shared.copy(), id) for id in lessons}

    def _key(self, found: hashlib._Hash, id: str) -> str:
        _add(found, self.places[id], _files(self.places[id]))
        _add(found, self.package, (path for path in _files(self.package / "locale") if path.name.split(".")[0] == id))
        return found.hexdigest()

    def _shared(self) -> Iterator[Path]:
        """The sources of the package that more than one lesson uses."""
        away = tuple(self.package / name for name in UNSHOWN)
        own = {place.name.replace("_", "-") for place in self.course.iterdir() if place.is_dir()} - {*SHARED_BY_LESSONS}
        for path in _files(self.package):
            if not any(path.is_relative_to(each) for each in away) and not ("locale" in path.parts and path.name.split(".")[0] in own):
                yield path


def _files(root: Path) -> list[Path]:
    if root.is_file():
        return [root]
    return sorted(path for path in root.rglob("*") if path.is_file() and "__pycache__" not in path.parts)


def _add(found: hashlib._Hash, root: Path, paths: Iterable[Path]) -> None:
    for path in paths:
        found.update(path.relative_to(root).as_posix().encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())


def _version(library: str) -> tuple[str, str]:
    """A library and its version, none where it is not installed."""
    try:
        return library, version(library)
    except PackageNotFoundError:
        return library, ""


def _on_other_pages(lesson: Lesson, languages: Iterable[str]) -> tuple[object, ...]:
    """What the pages of other lessons show of this one: its card in the list of lessons."""
    place, words = lesson.place, [lesson.words[language] for language in languages]
    picture = place.picture.read_bytes() if place.picture is not None and place.picture.is_file() else b""
    return (lesson.id, lesson.number, lesson.draft, [(each.title, each.question) for each in words], place.needs,
            [way.id for way in place.ways], len(lesson.tasks), [scene.id for scene in lesson.path], hashlib.sha256(picture).hexdigest())


@dataclass(frozen=True)
class Store:
    """A folder of recorded lessons: a folder for each lesson, and in it one for each key."""

    folder: Path

    def has(self, lesson: str, key: str) -> bool:
        """Whether the lesson is recorded as this key makes it."""
        return self._place(lesson, key).is_dir()

    def keep(self, lesson: str, key: str, record: Callable[[Write], object]) -> None:
        """Record a lesson; it is there once all of it is. Only the last used recordings of the lesson are kept."""
        place = self._place(lesson, key)
        partial = place.with_name(f".{os.getpid()}")
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir(parents=True)
        try:
            record(lambda name, words: write_file(partial, name, words))
            if not place.is_dir():
                partial.rename(place)
        finally:
            shutil.rmtree(partial, ignore_errors=True)
        kept = sorted((path for path in place.parent.iterdir() if not path.name.startswith(".")), key=lambda path: path.stat().st_mtime_ns)
        for path in kept[:-MOST_KEPT]:
            shutil.rmtree(path, ignore_errors=True)

    def copy(self, lesson: str, key: str, target: Path) -> None:
        """Make a folder hold the recorded lesson and nothing else; one that holds it already is left as it is."""
        place, note = self._place(lesson, key), target / KEY
        os.utime(place)
        if note.is_file() and note.read_text(encoding="utf-8") == key:
            return
        partial = target.with_name(f".{target.name}")
        shutil.rmtree(partial, ignore_errors=True)
        shutil.copytree(place, partial)
        write_file(partial, KEY, key)
        shutil.rmtree(target, ignore_errors=True)
        partial.rename(target)

    def _place(self, lesson: str, key: str) -> Path:
        return self.folder / lesson / key[:32]
