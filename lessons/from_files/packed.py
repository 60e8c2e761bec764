"""Write the lessons of a folder as one .zip, and open such a file."""

from __future__ import annotations

import atexit
import io
import re
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Lesson
from observer_lab.text import Text, text

from .folder import LessonFolder
from .picture import KINDS


class PackError(KnobError):
    """A .zip of lessons that cannot be opened or written; `text` is one sentence in every language."""


SUFFIXES = (".toml", ".md", ".json", ".mat", *KINDS)  # of files that hold no code
NAME = re.compile(r"[\w.-]{1,80}")
MAX_FILES, MAX_FILE_BYTES, MAX_BYTES = 400, 1_000_000, 20_000_000  # of a zip, unpacked
MAX_UPLOADED_LESSONS = 24  # of a zip that a page sends
PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # others may ask for gigabytes to unpack a byte
UNREADABLE = (zipfile.BadZipFile, OSError, NotImplementedError, RuntimeError, EOFError, UnicodeError, zlib.error)
PREFIX = "observer-lab-lessons-"  # of the folders that it is unpacked to
EPOCH = (1980, 1, 1, 0, 0, 0)  # the same file each time


def unpacked(file: Path) -> Path:
    """A folder with the lessons of a .zip, which goes with this process. Raises PackError."""
    home = Path(tempfile.mkdtemp(prefix=PREFIX))
    atexit.register(shutil.rmtree, home, ignore_errors=True)
    _unpack(file.name, file, home)
    return home


def uploaded_lessons(name: str, content: bytes, taken: Iterable[str]) -> Iterator[Lesson]:
    """The lessons of a .zip that a page has sent, each judged when it is asked for; none may have an id that is `taken`.

    No code of it runs, and nothing of it stays on the disk. Raises PackError.
    """
    with tempfile.TemporaryDirectory(prefix=PREFIX, ignore_cleanup_errors=True) as home:
        _unpack(name, io.BytesIO(content), Path(home))
        folder = LessonFolder(Path(home), tuple(taken), trusted=False, uploaded=True)
        count = folder.count()
        if not 0 < count <= MAX_UPLOADED_LESSONS:
            raise PackError(text("{file} holds {count} lessons; give it 1 to {most}.", file=name[:80], count=count,
                                 most=MAX_UPLOADED_LESSONS))
        yield from folder.read_each()


def _unpack(file: str, source: Path | IO[bytes], home: Path) -> None:
    """Write the files of a .zip below a folder. Raises PackError."""
    try:
        with zipfile.ZipFile(source) as packed:
            left = MAX_BYTES
            for entry, (folder, name) in _places(file, packed):
                with packed.open(entry) as part:
                    content = part.read(MAX_FILE_BYTES + 1)
                left -= len(content)
                if len(content) > MAX_FILE_BYTES or left < 0:
                    raise PackError(text("{file} is too large: a file may have 1 MB, all together 20 MB.", file=file[:80]))
                (home / folder).mkdir(exist_ok=True)
                (home / folder / name).write_bytes(content)
    except UNREADABLE as problem:
        raise PackError(text("{file} cannot be opened as a .zip of lessons.", file=file[:80])) from problem


def _places(file: str, packed: zipfile.ZipFile) -> list[tuple[zipfile.ZipInfo, tuple[str, str]]]:
    """Each file with its lesson's folder and its name, without a folder around all of them. Raises PackError."""
    entries = [entry for entry in packed.infolist() if not entry.is_dir()]
    if len(entries) > MAX_FILES:
        raise PackError(text("{file} holds too many files, more than {most:g}.", file=file[:80], most=MAX_FILES))
    if any(entry.compress_type not in PACKINGS for entry in entries):
        raise zipfile.BadZipFile
    parts = [tuple(entry.filename.split("/")) for entry in entries]
    if parts and _is_name(parts[0][0]) and all(len(each) == 3 and each[0] == parts[0][0] for each in parts):
        parts = [each[1:] for each in parts]
    for entry, each in zip(entries, parts, strict=True):
        if len(each) != 2 or not all(map(_is_name, each)):
            raise PackError(text("{file} holds “{name}”; a lesson is a folder with files, as tank-level/lesson.toml.", file=file[:80],
                                 name=entry.filename[:80]))
        if not each[1].lower().endswith(SUFFIXES):
            raise PackError(_no_code(file[:80], entry.filename[:80]))
    return [(entry, (each[0], each[1])) for entry, each in zip(entries, parts, strict=True)]


def _is_name(part: str) -> bool:
    return bool(NAME.fullmatch(part) and part.strip("."))


def _no_code(where: str, name: str) -> Text:
    return text("{where} holds “{name}”; a .zip of lessons has {suffixes} and no code. A server takes lessons with Python as a folder.",
                where=where, name=name, suffixes=", ".join(SUFFIXES))


def pack(folder: Path, file: str) -> int:
    """Write the lessons of a folder, which were read before, as a .zip; returns how many files it holds. Raises PackError."""
    found = sorted(path for place in folder.iterdir() if (place / "lesson.toml").is_file() for path in place.iterdir() if path.is_file())
    for path in found:
        if not path.name.lower().endswith(SUFFIXES):
            raise PackError(_no_code(folder.name[:80], f"{path.parent.name}/{path.name}"))
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as packed:
        for path in found:
            packed.writestr(zipfile.ZipInfo(f"{path.parent.name}/{path.name}", EPOCH), path.read_bytes(), zipfile.ZIP_DEFLATED)
    return len(found)
