"""The sheet after a lecture: every count of five or more is there once, none below, and no cell is a formula."""

from __future__ import annotations

import csv
import io
from html.parser import HTMLParser
from pathlib import Path

import pytest
from commands import refused
from hypothesis import given
from hypothesis import strategies as st

from observer_lab.classroom.answer_grids import PoleGrid, SketchGrid
from observer_lab.classroom.kept_room import KeptRoom
from observer_lab.classroom.room import UNSOLVED
from observer_lab.classroom.room_store import RoomStore
from observer_lab.classroom.votes import HIDDEN_BELOW, Asked, Vote
from observer_lab.cli import main
from observer_lab.lessons import LESSONS
from observer_lab.page.votes.lecture_sheet import FORMULA_SIGNS, sheet_csv, sheet_html, sheet_rows
from observer_lab.text import languages

PLACE, TASK = "separation/predict", f"{UNSOLVED}kalman/{LESSONS['kalman'].tasks[0].id}"
GRID = PoleGrid("observer", -10.0, 2.0, 8.0)


class Cells(HTMLParser):
    """The words of a page's cells."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self._inside = False
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag == "tr":
            self.rows.append([])
        if tag == "td":
            self.rows[-1].append("")
        self._inside = self._inside or tag == "td"

    def handle_endtag(self, tag: str) -> None:
        self._inside = self._inside and tag != "td"

    def handle_data(self, data: str) -> None:
        if self._inside and self.rows and self.rows[-1]:
            self.rows[-1][-1] += data


def lecture(store: KeptRoom) -> None:
    """Two votes on a scene, a typed one, poles, drawings, one with too few, one that is open; people at two places, too few at a third."""
    for answers in ([0, 0, 1, 2, 2, 2], [1] * 7):
        store.open_vote("separation", "predict", 3)
        store.cast([(store.votes()[-1].number, f"ballot{k:04d}", answer) for k, answer in enumerate(answers)])
    for asked, answers in ((Asked("=1+1", ("+A", "@B")), [0] * 5), (Asked("", (), GRID), [-4 + 2j] * 4 + [-1 + 0j]),
                           (Asked("How large?"), [1.5] * 6), (Asked("", sketch=SketchGrid(2, bars=True)), [(0.1, 0.9)] * 7),
                           (Asked("few", ("x", "y")), [0] * 4), (Asked("open", ("x", "y")), [1] * 9)):
        store.open_vote("separation", "drag", 0, asked)
        store.cast([(store.votes()[-1].number, f"ballot{k:04d}", answer) for k, answer in enumerate(answers)])
    store.report(0, {PLACE: 3, TASK: 6, "kalman": 4}, 0)
    store.report(1, {PLACE: 5}, 0)
    store.report(1, {PLACE: 1}, 0)


def test_the_sheet_has_every_count_of_five_or_more_once(store: KeptRoom) -> None:
    lecture(store)
    assert store.seen() == {PLACE: 8, TASK: 6}, "the most at once; four people are not kept"
    rows = sheet_rows(store.votes(), store.seen(), LESSONS, "en")
    assert {(row.lesson, row.scene, row.count) for row in rows if not row.answer} == {
        ("separation", "predict", 8), ("kalman", TASK.rpartition("/")[2], 6)}
    first = [row for row in rows if row.scene == "predict" and row.answer]
    assert [row.count for row in first] == [2, 1, 3, 0, 7, 0] and ["Vote 1" in row.what for row in first] == [True] * 3 + [False] * 3
    assert sorted(row.count for row in rows if row.scene == "drag") == [0, 1, 4, 5, 6, 7]
    assert not [row for row in rows if "few" in row.what or "open" in row.what]


@pytest.mark.parametrize("language", languages())
def test_page_and_table_say_the_same_in_every_language(tmp_path: Path, language: str, capsys: pytest.CaptureFixture[str]) -> None:
    store = RoomStore(tmp_path)
    lecture(store)
    rows = sheet_rows(store.votes(), store.seen(), LESSONS, language)
    table = list(csv.reader(io.StringIO(sheet_csv(rows, LESSONS, language))))
    assert [int(line[-1]) for line in table[1:]] == [row.count for row in rows] == [
        int(cells[-1]) for cells in Cells(sheet_html(rows, LESSONS, language)).rows]
    assert not [cell for line in table for cell in line if cell.startswith(FORMULA_SIGNS)]
    assert main(["lecture-sheet", str(tmp_path), "--lang", language]) == 0
    assert list(csv.reader(io.StringIO(capsys.readouterr().out))) == table
    assert main(["lecture-sheet", str(tmp_path), "--lang", language, "-o", str(tmp_path / "sheet.html")]) == 0
    assert (tmp_path / "sheet.html").read_text(encoding="utf-8") == sheet_html(rows, LESSONS, language)


@given(st.lists(st.tuples(st.integers(0, 9), st.booleans()), max_size=6),
       st.dictionaries(st.sampled_from([PLACE, TASK, "lqg/why", "gone/x"]), st.integers(0, 12)))
def test_no_count_of_fewer_than_five_people_is_on_the_sheet(votes: list[tuple[int, bool]], seen: dict[str, int]) -> None:
    found = [Vote(k + 1, "separation", "predict", k + 1, is_open, (total, 0, 0)) for k, (total, is_open) in enumerate(votes)]
    rows = sheet_rows(found, seen, LESSONS, "en")
    assert all(row.count >= HIDDEN_BELOW for row in rows if not row.answer)
    assert len([row for row in rows if row.answer]) == 3 * sum(total >= HIDDEN_BELOW and not is_open for total, is_open in votes)


def test_what_is_no_room_gets_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "holds no room" in refused(capsys, "lecture-sheet", str(tmp_path))
    assert "is no form of the sheet" in refused(capsys, "lecture-sheet", str(tmp_path), "-o", "sheet.pdf")
    (tmp_path / "room.sqlite").write_bytes(b"no database" * 100)
    assert "cannot be read" in refused(capsys, "lecture-sheet", str(tmp_path))
