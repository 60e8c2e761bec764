"""Keep the page that a room shows, packed, in a file that all workers of a server read."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from pathlib import Path

from .room_store import connect

FILE = "room-pages.sqlite"  # in the folder of --data-dir
LONGEST_LEAD_S = 60.0  # s that a lead can have been promised for; a later end was written before the machine began
KEPT_ACTS = 1000  # commands of a presenter that a slow worker may still read
KEPT_BATCHES = 400  # batches before the standing page that a slow worker may still read
SCHEMA = """
CREATE TABLE IF NOT EXISTS series (id INTEGER PRIMARY KEY CHECK (id = 1), number INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS wanted (page TEXT PRIMARY KEY);
CREATE TABLE IF NOT EXISTS pages (page TEXT PRIMARY KEY, series INTEGER NOT NULL, batch INTEGER NOT NULL, data BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS batches (page TEXT NOT NULL, series INTEGER NOT NULL, batch INTEGER NOT NULL, data BLOB NOT NULL,
  PRIMARY KEY (page, series, batch));
CREATE TABLE IF NOT EXISTS lead (id INTEGER PRIMARY KEY CHECK (id = 1), until REAL NOT NULL);
CREATE TABLE IF NOT EXISTS acts (number INTEGER PRIMARY KEY AUTOINCREMENT, words TEXT NOT NULL);
INSERT OR IGNORE INTO series VALUES (1, 0);
"""


@dataclass(frozen=True)
class StandingPage:
    """A whole page, and the number of the last batch that is in it."""

    series: int
    batch: int
    data: bytes


class PageStore:
    """Pages of one kind each (a language, a phone or a wide window): the whole, and the batches that came after it.

    Batches of one series follow each other on one page; another series begins on an empty page.
    """

    def __init__(self, folder: Path) -> None:
        """Raises sqlite3.Error where the folder cannot hold it."""
        self._lock, self._database = threading.RLock(), connect(folder / FILE, "OFF")  # a page can be made anew
        self._database.executescript(SCHEMA)

    def close(self) -> None:
        """Let go of the file."""
        with self._lock:
            self._database.close()

    def _run(self, words: str, *values: object) -> list[tuple]:
        with self._lock:
            return self._database.execute(words, values).fetchall()

    @property
    def series(self) -> int:
        """The number of the present series."""
        return int(self._run("SELECT number FROM series")[0][0])

    def begin_series(self) -> int:
        """Begin another series and give its number."""
        return int(self._run("UPDATE series SET number = number + 1 RETURNING number")[0][0])

    def want(self, page: str) -> None:
        """Somebody is here who needs this kind of page."""
        self._run("INSERT OR IGNORE INTO wanted VALUES (?)", page)

    def wanted(self) -> list[str]:
        """The kinds of pages that somebody needs."""
        return [str(row[0]) for row in self._run("SELECT page FROM wanted ORDER BY page")]

    def append(self, page: str, series: int, batch: int, data: bytes) -> None:
        """Add a batch to a page."""
        self._run("INSERT OR REPLACE INTO batches VALUES (?, ?, ?, ?)", page, series, batch, data)

    def stand(self, page: str, series: int, batch: int, data: bytes) -> None:
        """Keep the whole page as it is after a batch; those long before it go."""
        self._run("INSERT OR REPLACE INTO pages VALUES (?, ?, ?, ?)", page, series, batch, data)
        self._run("DELETE FROM batches WHERE page = ? AND (series < ? OR batch <= ?)", page, series, batch - KEPT_BATCHES)

    def standing(self, page: str) -> StandingPage | None:
        """The whole page as it was kept last."""
        rows = self._run("SELECT series, batch, data FROM pages WHERE page = ?", page)
        return StandingPage(*rows[0]) if rows else None

    def after(self, page: str, series: int, batch: int) -> list[tuple[int, bytes]]:
        """The batches of a series after that one, with their numbers."""
        return self._run("SELECT batch, data FROM batches WHERE page = ? AND series = ? AND batch > ? ORDER BY batch", page, series, batch)

    # --- the presenter's pages at several workers ------------------------------------------------------------------
    def keep_lead(self, seconds: float) -> None:
        """A page leads, and says so again within so many seconds."""
        self._run("INSERT OR REPLACE INTO lead VALUES (1, ?)", time.monotonic() + seconds)

    def end_lead(self) -> None:
        """The page that led has left."""
        self._run("DELETE FROM lead")

    def is_led(self) -> bool:
        """Whether a page leads."""
        now = time.monotonic()  # one clock for all processes, which begins anew with the machine
        return bool(self._run("SELECT 1 FROM lead WHERE until > ? AND until < ?", now, now + LONGEST_LEAD_S))

    def add_act(self, words: str) -> None:
        """Add a command of a presenter's hand."""
        number = self._run("INSERT INTO acts (words) VALUES (?) RETURNING number", words)[0][0]
        self._run("DELETE FROM acts WHERE number <= ?", number - KEPT_ACTS)

    def last_act(self) -> str:
        """The mark of the last command."""
        return str(self._run("SELECT COALESCE(MAX(number), 0) FROM acts")[0][0])

    def acts_after(self, mark: str) -> list[tuple[str, str]]:
        """The commands after the one of that mark, with their marks."""
        return [(str(number), words) for number, words in
                self._run("SELECT number, words FROM acts WHERE number > ? ORDER BY number", int(mark))]
