"""Hold the lessons that a person brings to a tab; write their .zip to keep it."""

from __future__ import annotations

import base64
import binascii
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from ...course.lesson import Lesson
from ...text import read_outside_json

MAX_ZIP_BYTES = 1_000_000
MAX_KEPT_ZIP_BYTES = 250_000  # bytes of a file that the browser's tab keeps through a reload; they come back in one message
MAX_NAME_CHARACTERS = 80
ReadLessons = Callable[[str, bytes, tuple[str, ...]], Iterator[Lesson]]  # name of a .zip, its bytes, ids that are taken


@dataclass(frozen=True, eq=False)
class OwnLessons:
    """Who reads a .zip of lessons, the file that is open, the ids of its lessons, and whether another one is read now.

    `lost` are the ids of lessons whose file the browser has not kept through a reload.
    """

    read: ReadLessons = field(repr=False)
    file: str = ""
    ids: tuple[str, ...] = ()
    reading: bool = False
    lost: tuple[str, ...] = ()


def write_zip(file: str, content: bytes) -> str:
    """A .zip as words that a browser keeps, "" where it is too large for that."""
    return json.dumps([file, base64.b64encode(content).decode("ascii")]) if len(content) <= MAX_KEPT_ZIP_BYTES else ""


def read_zip(words: object) -> tuple[str, bytes] | None:
    """Name and bytes of the .zip in such words, None where there is none."""
    try:
        match read_outside_json(words) if isinstance(words, str) else None:
            case [str(file), str(packed)] if len(packed) <= 2 * MAX_KEPT_ZIP_BYTES:
                return file[:MAX_NAME_CHARACTERS], base64.b64decode(packed, validate=True)
    except (ValueError, binascii.Error):
        pass
    return None
