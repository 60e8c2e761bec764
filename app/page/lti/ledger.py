"""Keep which logins were used, and what each student has handed in, for all workers."""

from __future__ import annotations

import hashlib
import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

FILE = "lti.sqlite"  # in the folder of --data-dir
WAIT_S = 10.0  # s that one worker waits for another one's writing
NONCE_KEPT_S = 3600  # s; a login holds for less
SCHEMA = """
CREATE TABLE IF NOT EXISTS nonces (nonce TEXT PRIMARY KEY, used INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS hand_ins (number INTEGER PRIMARY KEY, student TEXT NOT NULL, token TEXT NOT NULL UNIQUE);
CREATE INDEX IF NOT EXISTS of_student ON hand_ins (student);
CREATE TABLE IF NOT EXISTS reports (id INTEGER PRIMARY KEY CHECK (id = 1), ms INTEGER NOT NULL);
INSERT OR IGNORE INTO reports VALUES (1, 0);
"""


class Ledger:
    """A file in a folder. It holds keys of students, which name nobody, and what they handed in."""

    def __init__(self, folder: Path) -> None:
        """Raises sqlite3.Error or OSError where the folder cannot hold it."""
        self._path = folder / FILE
        os.close(os.open(self._path, os.O_CREAT | os.O_RDWR, 0o600))
        with self._open() as database:
            database.executescript(SCHEMA)

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        """A connection for one transaction: any thread of any worker may ask."""
        with closing(sqlite3.connect(self._path, timeout=WAIT_S)) as database, database:
            yield database

    def use_nonce(self, nonce: str) -> bool:
        """Note that a login is used; False where it was before."""
        with self._open() as database:
            database.execute("DELETE FROM nonces WHERE used < unixepoch() - ?", (NONCE_KEPT_S,))
            return database.execute("INSERT OR IGNORE INTO nonces VALUES (?, unixepoch())",
                                    (hashlib.sha256(nonce.encode()).hexdigest(),)).rowcount == 1

    def add(self, student: str, token: str, now: float) -> tuple[list[str], int]:
        """Keep a hand-in of a student's key; all that are kept of it in the order in which they came, and the time of that list (ms).

        No two lists have the same time, and a later one holds all that an earlier one does, whichever worker asked.
        """
        with self._open() as database:
            database.execute("INSERT OR IGNORE INTO hand_ins (student, token) VALUES (?, ?)", (student, token))
            (ms,) = database.execute("UPDATE reports SET ms = MAX(ms + 1, ?) RETURNING ms", (int(now * 1000),)).fetchone()
            tokens = database.execute("SELECT token FROM hand_ins WHERE student = ? ORDER BY number", (student,)).fetchall()
        return [str(row[0]) for row in tokens], int(ms)
