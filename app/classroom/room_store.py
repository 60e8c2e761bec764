"""Keep a room's votes and counts in SQLite, for all workers of a server and through its restart."""

from __future__ import annotations

import json
import os
import secrets
import sqlite3
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from .redis_connection import RoomProblem
from .votes import HIDDEN_BELOW, Answer, Asked, Vote, read_asked, write_asked

FILE = "room.sqlite"  # in the folder of --data-dir
WAIT_S = 10.0  # s that one worker waits for another one's writing
SECRET_BYTES = 24  # of the presenter's word
SEED_BITS = 63  # of the room's seed
FIRST = """
CREATE TABLE IF NOT EXISTS room (id INTEGER PRIMARY KEY CHECK (id = 1), secret TEXT NOT NULL, state TEXT NOT NULL, hands INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS votes (number INTEGER PRIMARY KEY, lesson TEXT NOT NULL, scene TEXT NOT NULL, round INTEGER NOT NULL,
  open INTEGER NOT NULL, counts TEXT NOT NULL, asked TEXT NOT NULL, edges TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS ballots (vote INTEGER NOT NULL, ballot TEXT NOT NULL, answer REAL NOT NULL, PRIMARY KEY (vote, ballot))
  WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS presence (worker INTEGER NOT NULL, place TEXT NOT NULL, people INTEGER NOT NULL, slower INTEGER NOT NULL,
  PRIMARY KEY (worker, place));
CREATE TABLE IF NOT EXISTS drawn (id INTEGER PRIMARY KEY CHECK (id = 1), seed INTEGER NOT NULL, taken INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS seats (seat INTEGER PRIMARY KEY, worker INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS runs (id INTEGER PRIMARY KEY CHECK (id = 1), number INTEGER NOT NULL, words TEXT NOT NULL);
INSERT OR IGNORE INTO runs VALUES (1, 0, '');
"""
STAGES = """
ALTER TABLE votes ADD COLUMN counts_out INTEGER NOT NULL DEFAULT 0;
ALTER TABLE votes ADD COLUMN revealed INTEGER NOT NULL DEFAULT 0;
ALTER TABLE votes ADD COLUMN talks INTEGER NOT NULL DEFAULT 0;
UPDATE votes SET counts_out = 1, revealed = 1 WHERE NOT open;
"""  # until then the counts and the answer were shown as soon as a vote was closed
SEEN = "CREATE TABLE seen (place TEXT PRIMARY KEY, people INTEGER NOT NULL)"  # the most people at a place at once, from five on
PAUSED = "ALTER TABLE room ADD COLUMN paused INTEGER NOT NULL DEFAULT 0"  # whether the pages of the class are paused
STEPS = (FIRST, STAGES, SEEN, PAUSED)  # the k-th leads to version k + 1


def connect(path: Path, synchronous: str) -> sqlite3.Connection:
    """A connection that several threads of a process may share, with a log that readers do not wait for. Raises sqlite3.Error."""
    database = sqlite3.connect(path, timeout=WAIT_S, check_same_thread=False, isolation_level=None)
    database.execute("PRAGMA journal_mode = WAL")
    database.execute(f"PRAGMA synchronous = {synchronous}")
    return database


class RoomStore:
    """The room in a folder. Each worker has a store of its own on the same file, opened after the workers have parted."""

    def __init__(self, folder: Path) -> None:
        """Raises sqlite3.Error or OSError where the folder cannot hold it."""
        path = folder / FILE
        with suppress(FileExistsError):  # it holds the presenter's word. Never opened here once SQLite has it: closing would end its locks
            os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        self._lock, self._database = threading.RLock(), connect(path, "FULL")
        bring_up_to_date(self._database)
        self._database.execute("INSERT OR IGNORE INTO room (id, secret, state, hands) VALUES (1, ?, '', 0)",
                               (secrets.token_urlsafe(SECRET_BYTES),))
        self._database.execute("INSERT OR IGNORE INTO drawn VALUES (1, ?, 0)", (secrets.randbits(SEED_BITS),))

    def close(self) -> None:
        """Let go of the file."""
        with self._lock:
            self._database.close()

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        """One transaction; what was written is on the disk when it ends."""
        with self._lock:
            self._database.execute("BEGIN IMMEDIATE")
            try:
                yield self._database
            except BaseException:
                self._database.execute("ROLLBACK")
                raise
            self._database.execute("COMMIT")

    def _read(self, question: str, *values: object) -> list[tuple]:
        with self._lock:
            return self._database.execute(question, values).fetchall()

    # --- the room --------------------------------------------------------------------------------------------------
    @property
    def secret(self) -> str:
        """The word that makes a presenter; drawn once, so that the link holds after a restart."""
        return str(self._read("SELECT secret FROM room")[0][0])

    @property
    def state(self) -> str:
        """The token of what the lecture showed last; "" before its beginning."""
        return str(self._read("SELECT state FROM room")[0][0])

    def keep_state(self, token: str) -> None:
        """Keep what the lecture shows."""
        with self._writing() as database:
            database.execute("UPDATE room SET state = ?", (token,))

    @property
    def paused(self) -> bool:
        """Whether the pages of the class are paused."""
        return bool(self._read("SELECT paused FROM room")[0][0])

    def pause(self, on: bool) -> None:
        """Pause the pages of the class, or let them go on."""
        with self._writing() as database:
            database.execute("UPDATE room SET paused = ?", (on,))

    # --- votes -----------------------------------------------------------------------------------------------------
    def open_vote(self, lesson: str, scene: str, options: int, asked: Asked | None = None) -> None:
        """Begin a vote on a scene's question with so many options, or on what was `asked` there; the one that was open ends."""
        words, count = write_asked(asked), options if asked is None else asked.places
        with self._writing() as database:
            self._close(database)
            before = database.execute("SELECT MAX(round) FROM votes WHERE lesson = ? AND scene = ? AND asked = ?",
                                      (lesson, scene, words)).fetchone()[0]
            database.execute("INSERT INTO votes (lesson, scene, round, open, counts, asked, edges) VALUES (?, ?, ?, 1, ?, ?, '[]')",
                             (lesson, scene, (before or 0) + 1, json.dumps([0] * count), words))

    def close_vote(self) -> None:
        """Take no more votes: their counts stay, the ballots go."""
        with self._writing() as database:
            self._close(database)

    def mark_vote(self, vote: Vote) -> None:
        """Write down of a closed vote whether its counts are shown, its answer is told, and how often it was put up for discussion."""
        with self._writing() as database:
            database.execute("UPDATE votes SET counts_out = ?, revealed = ?, talks = ? WHERE number = ? AND NOT open",
                             (vote.counts_out, vote.revealed, vote.talks, vote.number))

    def _close(self, database: sqlite3.Connection) -> None:
        for vote in self._votes(database, "WHERE open"):
            database.execute("UPDATE votes SET open = 0, counts = ?, edges = ? WHERE number = ?",
                             (json.dumps(vote.counts), json.dumps(vote.edges), vote.number))
        database.execute("DELETE FROM ballots")

    def cast(self, ballots: Iterable[tuple[int, str, Answer]]) -> list[bool]:
        """Write (vote, ballot, answer) down, all in one transaction; for each whether it counts. A newer one replaces an older one.

        The answer is the index of an option; where one was asked for a number, a pole (complex), or heights of a drawing.
        """
        with self._writing() as database:
            open_now = {vote.number: vote for vote in self._votes(database, "WHERE open")}
            taken = []
            for number, ballot, answer in ballots:
                kept = open_now[number].kept(answer) if number in open_now else None
                taken.append(kept is not None)
                if kept is not None:
                    database.execute("INSERT OR REPLACE INTO ballots VALUES (?, ?, ?)", (number, ballot, kept))
            return taken

    def votes(self) -> tuple[Vote, ...]:
        """All votes, the open one with its counts as they are now."""
        with self._lock:
            return tuple(self._votes(self._database))

    def _votes(self, database: sqlite3.Connection, which: str = "") -> list[Vote]:
        out = []
        for number, lesson, scene, times, is_open, counts, asked, edges, out_now, revealed, talks in database.execute(
                "SELECT number, lesson, scene, round, open, counts, asked, edges, counts_out, revealed, talks FROM votes "
                f"{which} ORDER BY number").fetchall():
            vote = Vote(number, lesson, scene, times, bool(is_open), tuple(json.loads(counts)), read_asked(asked),
                        tuple(json.loads(edges)), bool(out_now), bool(revealed), talks)
            if is_open:
                answers = database.execute("SELECT answer FROM ballots WHERE vote = ?", (number,)).fetchall()
                vote = vote.counting([answer for (answer,) in answers])
            out.append(vote)
        return out

    # --- who is here -----------------------------------------------------------------------------------------------
    def report(self, worker: int, people: Mapping[str, int], slower: int) -> None:
        """What a worker counts by place; `slower` are the hands that are raised there."""
        with self._writing() as database:
            database.execute("DELETE FROM presence WHERE worker = ?", (worker,))
            database.executemany("INSERT INTO presence VALUES (?, ?, ?, 0)", [(worker, place, count) for place, count in people.items()])
            database.execute("INSERT OR REPLACE INTO presence VALUES (?, '', 0, ?)", (worker, slower))
            database.execute("INSERT INTO seen SELECT place, SUM(people) AS people FROM presence WHERE place != '' GROUP BY place HAVING "
                             "SUM(people) >= ? ON CONFLICT (place) DO UPDATE SET people = MAX(people, excluded.people)", (HIDDEN_BELOW,))

    def seen(self) -> dict[str, int]:
        """The most people that were at each place at once; a place where fewer than five were is not kept."""
        return dict(self._read("SELECT place, people FROM seen ORDER BY place"))

    def presence(self) -> tuple[dict[str, int], int]:
        """The counts of all workers by place, and the raised hands."""
        people = dict(self._read("SELECT place, SUM(people) FROM presence WHERE place != '' GROUP BY place"))
        return people, int(self._read("SELECT COALESCE(SUM(slower), 0) FROM presence")[0][0])

    def forget_presence(self) -> None:
        """Nobody is here yet: the server has just begun."""
        with self._writing() as database:
            database.execute("DELETE FROM presence")
            database.execute("DELETE FROM seats")
            database.execute("UPDATE runs SET number = number + 1, words = ''")

    @property
    def hands(self) -> int:
        """How often the presenter has lowered all hands."""
        return int(self._read("SELECT hands FROM room")[0][0])

    def lower_hands(self) -> None:
        """Every raised hand is lowered."""
        with self._writing() as database:
            database.execute("UPDATE room SET hands = hands + 1")
            database.execute("UPDATE presence SET slower = 0")

    # --- a run for each follower -------------------------------------------------------------------------------------
    @property
    def seed(self) -> int:
        """The seed of the room, from which those of the followers are drawn."""
        return int(self._read("SELECT seed FROM drawn")[0][0])

    def take_seats(self, worker: int, count: int) -> list[int]:
        """Numbers for so many followers who have come to a worker; no number is given twice."""
        with self._writing() as database:
            last = database.execute("UPDATE drawn SET taken = taken + ? RETURNING taken", (count,)).fetchone()[0]
            seats = list(range(last - count + 1, last + 1))
            database.executemany("INSERT INTO seats VALUES (?, ?)", [(seat, worker) for seat in seats])
            return seats

    def leave_seats(self, seats: Iterable[int]) -> None:
        """Those followers have left."""
        with self._writing() as database:
            database.executemany("DELETE FROM seats WHERE seat = ?", [(seat,) for seat in seats])

    def empty_worker(self, worker: int) -> None:
        """Nobody follows at a worker: it has just begun."""
        with self._writing() as database:
            database.execute("DELETE FROM seats WHERE worker = ?", (worker,))

    def seats(self) -> tuple[int, ...]:
        """The numbers of all who follow, in all workers."""
        return tuple(seat for (seat,) in self._read("SELECT seat FROM seats ORDER BY seat"))

    def keep_runs(self, words: str) -> None:
        """Keep the runs of the class; "" takes them away."""
        with self._writing() as database:
            database.execute("UPDATE runs SET number = number + 1, words = ?", (words,))

    @property
    def run_number(self) -> int:
        """How often the runs of the class have changed."""
        return int(self._read("SELECT number FROM runs")[0][0])

    def runs(self) -> str:
        """The runs of the class; "" where there are none."""
        return str(self._read("SELECT words FROM runs")[0][0])


def bring_up_to_date(database: sqlite3.Connection) -> None:
    """Take the steps that the file lacks, all or none. Raises sqlite3.Error, or RoomProblem where a later version wrote it."""
    database.execute("BEGIN IMMEDIATE")
    try:
        version = database.execute("PRAGMA user_version").fetchone()[0]
        if version > len(STEPS):
            raise RoomProblem("room.sqlite was written by a later version of Observer Lab; use that version, or another folder.")
        for step in STEPS[version:]:
            for statement in filter(None, map(str.strip, step.split(";"))):
                database.execute(statement)
        database.execute(f"PRAGMA user_version = {len(STEPS)}")
    except BaseException:
        database.execute("ROLLBACK")
        raise
    database.execute("COMMIT")
