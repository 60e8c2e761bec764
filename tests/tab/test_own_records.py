"""A person's own record in a tab: look at it, say what its columns are, use it; a bad file costs one sentence."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fakes import Tab

from observer_lab.lessons import LESSONS
from observer_lab.page.column.record_picker import preview_html
from observer_lab.session.commands.commands import Command, Notice, OpenLesson, Predict
from observer_lab.session.commands.files import DownloadFile
from observer_lab.session.commands.records import DropRecord, SetColumnRole, TellOfRecord, UploadRecord, UseRecord
from observer_lab.session.state.record_file import MAX_COLUMNS, MAX_RECORD_BYTES, RecordFile

ROWS, GONE, EMPTY = 300, (50, 51, 120), (7, 90)  # rows that are missing; rows whose output is empty


def heater(head: str = "Zeit;Heizung [V];T1 [°C];Raum") -> bytes:
    """A semicolon file with decimal commas, times as in ISO 8601 and gaps: a heater that is switched, a temperature."""
    rng, x, rows = np.random.default_rng(1), 0.0, [head]
    for k in range(ROWS):
        u = 1.5 * (k // 7 % 2)
        x = 0.9 * x + 0.2 * u + 0.05 * rng.standard_normal()
        y = "" if k in EMPTY else f"{x + 20:.4f}"
        if k not in GONE:
            rows.append(f"2026-01-05T10:{k // 60:02d}:{k % 60:02d};{u};{y};21.5".replace(".", ","))
    return "\n".join(rows).encode()


class AtOnce:
    """Background jobs that are done where they are sent."""

    def __init__(self, post: Callable[[Notice], object], *_: object, **__: object) -> None:
        self._post = post

    def send(self, job: Callable[[], Notice]) -> bool:
        self._post(job())
        return True

    def tell(self, notice: Notice) -> bool:
        self._post(notice)
        return True


@pytest.fixture
def tab(monkeypatch: pytest.MonkeyPatch) -> Tab:
    monkeypatch.setattr("observer_lab.session.session.BackgroundJobs", AtOnce)
    return Tab({name: LESSONS[name] for name in ("record", "kalman")}, "record")


def use(tab: Tab) -> None:
    """Use the record that is looked at, whose fit is through at once."""
    tab.do(UseRecord())
    tab.session.step(0.0)


def file_of(tab: Tab) -> RecordFile:
    file = tab.picture.state.record_file
    assert file is not None
    return file


def test_an_upload_asks_for_the_columns_and_the_lesson_then_runs_on_it(tab: Tab) -> None:
    before = tab.picture.design
    tab.do(UploadRecord("heater.csv", heater()))
    assert "say which one is the time" in preview_html(file_of(tab), "en") and file_of(tab).preview.record is None
    tab.do(UseRecord())
    assert tab.view.scolded() and tab.picture.design == before
    for place, role in ((0, "t"), (1, "u"), (2, "y")):
        tab.do(SetColumnRole(place, role))
    record = file_of(tab).preview.record
    assert record is not None and (record.dt, record.rows) == (1.0, ROWS)
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(record.y[:, 0])), sorted((*GONE, *EMPTY)))
    shown = preview_html(file_of(tab), "en")
    for words in ("Step 1 s, 300 rows, 300 s.", "Rows that are missing: 3.", "T1: values that are missing: 2.", "not used: Raum",
                  "Heizung [V]"):
        assert words in shown
    assert shown.count("<polyline") == 1 + 5  # a curve ends at each gap
    use(tab)
    assert tab["data"] == "own" and tab.picture.outcome.study.given.own and tab.picture.state.record_file is None
    study = tab.picture.outcome.study
    assert tab["order"] == study.found.subspace.suggested == 1 and study.judged.evidence.stable  # the lesson opens at that order
    assert LESSONS["record"].start()["data"] != "own"  # the file belongs to this tab alone
    tab.set(order=1)
    assert tab.picture.outcome.study.found.record.rows == ROWS
    assert np.ptp(tab.picture.outcome.study.predicted) < 5 and np.isfinite(tab.picture.outcome.stage.x).all()  # missing rows too


def test_a_second_record_takes_the_place_of_the_first(tab: Tab) -> None:
    for rows in (300, 200):
        tab.do(UploadRecord("heater.csv", b"\n".join(heater("t;raum;y;u").split(b"\n")[:rows])))
        tab.do(SetColumnRole(1, "u"))
        tab.do(SetColumnRole(3, ""))
        use(tab)
    assert tab.picture.outcome.study.found.record.t[-1] < 205 and tab["data"] == "own"


def test_questions_are_answered_in_the_page(tab: Tab) -> None:
    rows = "".join(f"{1000 * k},{-999 if k == 5 else k % 3},{'' if k == 9 else k % 7}.5\n" for k in range(40))
    tab.do(UploadRecord("log.csv", ("t,y,u\n" + rows.replace(",.5", ",")).encode()))
    for name, value in (("unit", "ms"), ("missing", "-999"), ("hold", True)):
        assert file_of(tab).preview.record is None, name
        tab.do(TellOfRecord(name, value))
    record = file_of(tab).preview.record
    assert record is not None and record.dt == 1.0 and np.isnan(record.y[5, 0]) and record.u[9, 0] == record.u[8, 0]
    tab.do(TellOfRecord("step", 0.5))
    tab.do(SetColumnRole(0, ""))
    found = file_of(tab).preview.record
    assert found is not None and found.dt == 0.5
    tab.do(DropRecord())
    assert tab.picture.state.record_file is None


@pytest.mark.parametrize("command", [
    UploadRecord("a.csv", None), UploadRecord(None, b"t,y\n"), UploadRecord("a.csv", b"\xff\x00\x01" * 40), UploadRecord("a.csv", b""),
    UploadRecord("plant.json", b'{"A": [[1]]}'), UploadRecord("large.csv", b"1" * (MAX_RECORD_BYTES + 1)),
    UploadRecord("wide.csv", b"\n".join([b",".join([b"1"] * (MAX_COLUMNS + 1))] * 12)),
    SetColumnRole(9, "u"), SetColumnRole("first", "u"), SetColumnRole(0, "x"), SetColumnRole(0, []), TellOfRecord("unit", "furlong"),
    TellOfRecord("step", float("nan")), TellOfRecord("step", -1), TellOfRecord("missing", None), TellOfRecord("name", "x"),
    TellOfRecord("unit", []), TellOfRecord("missing", "often")])
def test_a_bad_file_or_value_costs_one_sentence_and_the_last_preview_stays(tab: Tab, command: Command) -> None:
    tab.do(UploadRecord("heater.csv", heater("t;u;y;raum")))
    design, before = tab.picture.design, file_of(tab).preview.columns
    tab.view.clear()
    tab.do(command)
    assert len(tab.view.scolded()) == 1 or file_of(tab).preview.problem is not None
    assert not any("error in the program" in words("en") for words in tab.view.scolded())
    assert (tab.picture.design, file_of(tab).preview.columns) == (design, before)


def test_nothing_is_done_without_a_file_or_in_another_lesson(tab: Tab) -> None:
    for command in (UseRecord(), SetColumnRole(0, "t"), TellOfRecord("unit", "s")):
        tab.do(command)
    tab.do(OpenLesson("kalman"))
    tab.do(UploadRecord("heater.csv", heater()))
    assert len(tab.view.scolded()) == 4 and tab.picture.state.record_file is None


@pytest.mark.slow
def test_a_file_becomes_a_filter_that_runs_on_its_second_half(tab: Tab, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Semicolons, decimal commas, gaps and times as in ISO 8601: read in the page, used, exported, and run on rows it was not fitted to."""
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    tab = Tab({"record": LESSONS["record"]}, "record")
    tab.do(UploadRecord("heater.csv", heater()))
    for place, role in ((0, "t"), (1, "u"), (2, "y")):
        tab.do(SetColumnRole(place, role))
    record = file_of(tab).preview.record
    assert record is not None
    tab.do(Predict(0))
    use(tab)
    tab.set(order=1)
    tab.do(DownloadFile("python"))
    tab.session.step(0.0)
    (_, content), = tab.view.of("file")
    script = tmp_path / "heater.py"
    script.write_bytes(content)
    names = runpy.run_path(str(script))
    half = record.rows // 2
    _, estimate, sigma, _ = names["estimate"](record.t[half:], record.u[half:], record.y[half:])
    away = (record.y[half + record.rows - half - len(estimate):] - estimate)[30:]
    assert np.nanstd(away) < 0.5 * np.nanstd(record.y[half:]) and np.all(sigma > 0)
