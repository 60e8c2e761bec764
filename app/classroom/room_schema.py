"""Bring the file of a room to the form that this version writes, from any earlier one."""

from __future__ import annotations

import sqlite3

from .redis_connection import RoomProblem

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
