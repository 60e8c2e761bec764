"""Files are made beside the worker, of what was shown when they were asked for, and come back like any other edit."""

from __future__ import annotations

import json
import threading

import pytest
from fakes import Tab

from observer_lab.session.commands.commands import Edit, Predict
from observer_lab.session.commands.files import DownloadFile, FileReady
from observer_lab.session.handlers import downloads
from observer_lab.session.handlers.playback import PREDICT_FIRST
from observer_lab.session.runtime import background_jobs
from observer_lab.session.state.token import read_token


class Waiting(background_jobs.BackgroundJobs):
    """Background jobs that are done when the test says so."""

    def send(self, errand) -> bool:
        self._waiting.append(errand)
        return True

    def all_done(self) -> None:
        while self._waiting:
            self._post(self._waiting.popleft()())


def slow_tab(monkeypatch: pytest.MonkeyPatch) -> tuple[Tab, Waiting]:
    monkeypatch.setattr("observer_lab.session.session.BackgroundJobs", Waiting)
    tab = Tab()
    return tab, tab.session._show.background  # type: ignore[return-value]


def test_a_file_is_of_the_moment_it_was_asked_in_and_the_hand_goes_on_meanwhile(monkeypatch: pytest.MonkeyPatch) -> None:
    tab, waiting = slow_tab(monkeypatch)
    tab.set(gain=2.0)
    tab.do(DownloadFile("json", "x"))
    tab.set(gain=5.0)
    assert tab["gain"] == 5.0 and tab.view.of("file") == []
    waiting.all_done()
    tab.session.step(0.0)
    (name, content), = tab.view.of("file")
    assert name == "toy-x.json" and read_token(json.loads(content)["token"], tab.lessons).design["gain"] == 2.0
    assert json.loads(content)["rows"][0][1] == 2.0


def test_a_replay_is_of_the_moment_it_was_asked_in_and_of_no_run_before_its_prediction(monkeypatch: pytest.MonkeyPatch) -> None:
    tab, waiting = slow_tab(monkeypatch)
    tab.do(DownloadFile("replay"))
    assert tab.view.sentences() == [PREDICT_FIRST] and not waiting._waiting
    tab.do(Predict(0))
    tab.set(gain=2.0)
    tab.view.looks = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    tab.do(DownloadFile("replay"))
    tab.view.looks = None
    tab.set(gain=5.0)
    waiting.all_done()
    tab.session.step(0.0)
    (name, content), = tab.view.of("file")
    token, camera = content.decode().split(" ", 1)
    saved = read_token(token, tab.lessons)
    assert name == "toy-replay.html" and saved.design["gain"] == 2.0 and camera == str(saved.camera) == "(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)"


def test_what_cannot_be_made_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    tab, waiting = slow_tab(monkeypatch)
    for kind in ("python", "matlab", "exe", "csv"):
        tab.do(DownloadFile(kind, "" if kind != "csv" else "nothing"))
    monkeypatch.setattr("observer_lab.export.files.all_in_one", lambda taken: 1 / 0)
    tab.do(DownloadFile("zip"))
    waiting.all_done()
    tab.session.step(0.0)
    assert len(tab.view.scolded()) == 5 and tab.view.of("file") == []
    assert tab.view.sentences()[0] == downloads.FILE_IN_PROGRESS


def test_errands_are_done_in_order_and_not_without_end() -> None:
    done: list[Edit] = []
    here, goes = threading.Event(), threading.Event()
    last = threading.Event()

    def first() -> Edit:
        here.set()
        goes.wait()
        return FileReady("0", b"")

    def post(edit: Edit) -> None:
        done.append(edit)
        if len(done) == background_jobs.MAX_QUEUED_JOBS + 1:
            last.set()
    several = background_jobs.BackgroundJobs(post)
    assert several.send(first)
    here.wait()
    taken = [several.send(lambda k=k: FileReady(str(k), b"")) for k in range(1, background_jobs.MAX_QUEUED_JOBS + 3)]
    assert taken == [True] * background_jobs.MAX_QUEUED_JOBS + [False] * 2
    goes.set()
    last.wait()
    assert done == [FileReady(str(k), b"") for k in range(background_jobs.MAX_QUEUED_JOBS + 1)]
