"""Append the finished rows of a study to a file, so that an interrupted study can go on.

Each line is a check sum and JSON: first whose study it is, then the rows of one chunk after another, each on the disk before
the next is begun. A line that is torn is passed over, and its runs are computed again.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

from .plan import Row, Study, StudyError


class Ledger:
    """The rows of a study that are known, and the file that they are added to. A context that closes the file."""

    def __init__(self, path: Path, study: Study, mark: str) -> None:
        """Go on with the file, or begin it. Raises StudyError where it is another study's, OSError where it cannot be used."""
        self.rows: dict[int, Row] = {}
        self._file: BinaryIO = path.open("ab")
        try:
            self._begin(path, study, mark)
        except BaseException:
            self._file.close()
            raise

    def _begin(self, path: Path, study: Study, mark: str) -> None:
        _alone(self._file, path)
        whole = _whole_lines(path)
        head = _opened(whole[0]) if whole else None
        if whole and not (isinstance(head, dict) and "study" in head):
            raise StudyError(f"{path.name[:80]} is no record of a study; choose another folder with -o.")
        if isinstance(head, dict) and head["study"] != mark:
            raise StudyError(f"{str(path.parent)[:80]} holds another study, or this one by other versions of the programs; choose "
                             "another folder with -o, or remove it.")
        for line in whole[1:]:
            for row in _rows(_opened(line), study):
                self.rows[row.index] = row
        self._file.truncate(sum(map(len, whole)))  # a torn line would swallow the next one
        if not whole:
            self._write({"study": mark})

    def add(self, rows: Sequence[Row]) -> None:
        """Write rows down; they are on the disk when this returns. Raises OSError."""
        self._write([[row.index, list(row.values), row.problem] for row in rows])
        self.rows.update((row.index, row) for row in rows)

    def _write(self, content: Any) -> None:
        words = json.dumps(content, separators=(",", ":")).encode("ascii")
        self._file.write(b"%08x %s\n" % (zlib.crc32(words), words))
        self._file.flush()
        os.fsync(self._file.fileno())

    def __enter__(self) -> Ledger:
        return self

    def __exit__(self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None) -> None:
        self._file.close()


def _alone(file: BinaryIO, path: Path) -> None:
    """Keep others from writing to the file while it is open, where the system can. Raises StudyError where somebody does."""
    try:
        import fcntl
    except ImportError:  # Windows
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as problem:
        raise StudyError(f"Another command is at work in {str(path.parent)[:80]}; wait for it, or choose another folder with "
                         "-o.") from problem


def _whole_lines(path: Path) -> list[bytes]:
    """The lines of a file with their ends, but for a last one that has none."""
    lines = path.read_bytes().splitlines(keepends=True)
    return lines if not lines or lines[-1].endswith(b"\n") else lines[:-1]


def _opened(line: bytes) -> Any:
    """What a line holds, None where its check sum is wrong."""
    check, _, words = line.rstrip(b"\n").partition(b" ")
    return json.loads(words) if check == b"%08x" % zlib.crc32(words) else None


def _rows(content: Any, study: Study) -> list[Row]:
    if content is None:
        return []
    return [Row(index, tuple(values), problem) for index, values, problem in content
            if 0 <= index < study.size and len(values) == len(study.collect)]
