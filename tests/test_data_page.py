"""The page on personal data names the files that a server writes, and its commands do what it says."""

from __future__ import annotations

import re
import shutil
import sqlite3
import subprocess
from pathlib import Path

import pytest

from observer_lab.classroom.room_store import FILE as ROOM_FILE
from observer_lab.cli.logs import LOG_FILES, LOG_NAME, MAX_LOG_BYTES
from observer_lab.course.handin.ledger import FILE, Ledger
from observer_lab.page.words import phrases

PAGE = (Path(__file__).parents[1] / "assets" / "deploy" / "data.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"```sh\n(.*?)\n```", PAGE, re.DOTALL)


def test_every_file_and_button_that_it_names_is_there() -> None:
    for name in (FILE, ROOM_FILE, LOG_NAME):
        assert f"`{name}`" in PAGE
    assert phrases.WIPE("en") in PAGE
    assert MAX_LOG_BYTES == 1_000_000 and f"{('five', 'six', 'seven')[LOG_FILES - 4]} files" in PAGE
    for script in re.findall(r"`(tests/benchmarks/\w+\.py)`", PAGE):
        assert (Path(__file__).parents[1] / script).is_file()


def test_its_statement_deletes_one_student_and_no_other(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    ledger.add("KEY", "a", 1.0)
    ledger.add("OTHER", "b", 1.0)
    (statement,) = re.findall(r'"(DELETE .*?)"', COMMANDS[0])
    with sqlite3.connect(tmp_path / FILE) as database:
        database.execute(statement)
    assert Ledger(tmp_path).add("KEY", "c", 2.0)[0] == ["c"] and Ledger(tmp_path).add("OTHER", "d", 2.0)[0] == ["b", "d"]


@pytest.mark.skipif(shutil.which("sqlite3") is None, reason="sqlite3 is not installed")
def test_its_backup_holds_the_hand_ins(tmp_path: Path) -> None:
    Ledger(tmp_path).add("KEY", "a", 1.0)
    subprocess.run(COMMANDS[1].replace("FOLDER", str(tmp_path)), shell=True, check=True, cwd=tmp_path, timeout=60)
    with sqlite3.connect(tmp_path / "kept.sqlite") as database:
        assert database.execute("SELECT student FROM hand_ins").fetchall() == [("KEY",)]
