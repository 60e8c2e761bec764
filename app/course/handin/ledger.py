"""Keep what each student has handed in, and which logins were used, for all workers of a server."""

from __future__ import annotations

import hashlib
import os
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Protocol

FILE = "course.sqlite"  # in the folder of --data-dir
EARLIER_FILE = "lti.sqlite"  # as it was called while platforms alone were served
WAIT_S = 10.0  # s that one worker waits for another one's writing
NONCE_KEPT_S = 3600  # s; a login holds for less
INSERT = "INSERT OR IGNORE INTO hand_ins (student, token) VALUES (?, ?)"
VERSION = 1  # of the schema, in the file as user_version; a file from before it had one says 0 and has the same tables
SCHEMA = """
CREATE TABLE IF NOT EXISTS nonces (nonce TEXT PRIMARY KEY, used INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS hand_ins (number INTEGER PRIMARY KEY, student TEXT NOT NULL, token TEXT NOT NULL UNIQUE);
CREATE INDEX IF NOT EXISTS of_student ON hand_ins (student);
CREATE TABLE IF NOT EXISTS reports (id INTEGER PRIMARY KEY CHECK (id = 1), ms INTEGER NOT NULL);
INSERT OR IGNORE INTO reports VALUES (1, 0);
"""


class KeptHandIns(Protocol):
    """What hand-ins and logins are kept in, for all workers. `Ledger` says what each method does."""

    failing: bool

    def use_nonce(self, nonce: str) -> bool: ...
    def choose(self, student: str, pick: Callable[[Sequence[str]], str | None]) -> str | None: ...
    def add(self, student: str, token: str, now: float) -> tuple[list[str], int]: ...


class Ledger:
    """A file in a folder. It holds keys of students, which name nobody where a platform gave them, and what they handed in."""

    def __init__(self, folder: Path) -> None:
        """Raises sqlite3.Error or OSError where the folder cannot hold it."""
        self._path, self.failing = folder / FILE, False  # whether the last login or hand-in could not be kept
        if not self._path.exists() and (folder / EARLIER_FILE).exists():
            (folder / EARLIER_FILE).rename(self._path)
        with suppress(FileExistsError):  # never opened here once SQLite has it: closing would end its locks
            os.close(os.open(self._path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        with self._open() as database:
            (version,) = database.execute("PRAGMA user_version").fetchone()
            if version > VERSION:
                raise sqlite3.Error("it was written by a later version of Observer Lab; install that one")
            database.executescript(f"{SCHEMA}PRAGMA user_version = {VERSION};")

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        """A connection: any thread of any worker may ask."""
        with closing(sqlite3.connect(self._path, timeout=WAIT_S)) as database, database:
            yield database

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        """A connection for one transaction, within which nobody else writes. Raises OSError."""
        try:
            with self._open() as database:
                database.execute("BEGIN IMMEDIATE")
                yield database
            self.failing = False
        except sqlite3.Error as problem:
            self.failing = True
            raise OSError(str(problem)) from problem

    def use_nonce(self, nonce: str) -> bool:
        """Note that a login is used; False where it was before. Raises OSError."""
        with self._transaction() as database:
            database.execute("DELETE FROM nonces WHERE used < unixepoch() - ?", (NONCE_KEPT_S,))
            return database.execute("INSERT OR IGNORE INTO nonces VALUES (?, unixepoch())",
                                    (hashlib.sha256(nonce.encode()).hexdigest(),)).rowcount == 1

    def choose(self, student: str, pick: Callable[[Sequence[str]], str | None]) -> str | None:
        """Keep the token that `pick` gives for those kept of a student, None for none; nobody else writes meanwhile. Raises OSError."""
        with self._transaction() as database:
            token = pick(_tokens(database, student))
            if token is not None:
                database.execute(INSERT, (student, token))
            return token

    def add(self, student: str, token: str, now: float) -> tuple[list[str], int]:
        """Keep a hand-in of a student's key; all that are kept of it in the order in which they came, and the time of that list (ms).

        No two lists have the same time, and a later one holds all that an earlier one does, whichever worker asked. Raises OSError.
        """
        with self._transaction() as database:
            database.execute(INSERT, (student, token))
            (ms,) = database.execute("UPDATE reports SET ms = MAX(ms + 1, ?) RETURNING ms", (int(now * 1000),)).fetchone()
            return _tokens(database, student), int(ms)


def _tokens(database: sqlite3.Connection, student: str) -> list[str]:
    return [str(row[0]) for row in database.execute("SELECT token FROM hand_ins WHERE student = ? ORDER BY number", (student,))]
