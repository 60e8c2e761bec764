"""Files are made beside the worker, of what was shown when they were asked for, and come back like any other edit."""

from __future__ import annotations

import json
import threading

import pytest
from fakes import Tab

from app.tab import errands, taking
from app.tab.commands import Edit, Predict
from app.tab.orders import Made, TakeFile
from app.tab.playing import PREDICT_FIRST
from app.tab.token import read_token


class Waiting(errands.Errands):
    """Errands that are done when the test says so."""

    def send(self, errand) -> bool:
        self._waiting.append(errand)
        return True

    def all_done(self) -> None:
        while self._waiting:
            self._post(self._waiting.popleft()())


def slow_tab(monkeypatch: pytest.MonkeyPatch) -> tuple[Tab, Waiting]:
    monkeypatch.setattr("app.tab.session.Errands", Waiting)
    tab = Tab()
    return tab, tab.session._errands  # type: ignore[return-value]


def test_a_file_is_of_the_moment_it_was_asked_in_and_the_hand_goes_on_meanwhile(monkeypatch: pytest.MonkeyPatch) -> None:
    tab, waiting = slow_tab(monkeypatch)
    tab.set(gain=2.0)
    tab.do(TakeFile("json", "x"))
    tab.set(gain=5.0)
    assert tab["gain"] == 5.0 and tab.view.of("file") == []
    waiting.all_done()
    tab.session.step(0.0)
    (name, content), = tab.view.of("file")
    assert name == "toy-x.json" and read_token(json.loads(content)["token"], tab.lessons).design["gain"] == 2.0
    assert json.loads(content)["rows"][0][1] == 2.0


def test_a_replay_is_of_the_moment_it_was_asked_in_and_of_no_run_before_its_prediction(monkeypatch: pytest.MonkeyPatch) -> None:
    tab, waiting = slow_tab(monkeypatch)
    tab.do(TakeFile("replay"))
    assert tab.view.sentences() == [PREDICT_FIRST] and not waiting._waiting
    tab.do(Predict(0))
    tab.set(gain=2.0)
    tab.view.looks = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    tab.do(TakeFile("replay"))
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
        tab.do(TakeFile(kind, "" if kind != "csv" else "nothing"))
    monkeypatch.setattr("app.export.files.all_in_one", lambda taken: 1 / 0)
    tab.do(TakeFile("zip"))
    waiting.all_done()
    tab.session.step(0.0)
    assert len(tab.view.scolded()) == 5 and tab.view.of("file") == []
    assert tab.view.sentences()[0] == taking.COMING


def test_errands_are_done_in_order_and_not_without_end() -> None:
    done: list[Edit] = []
    here, goes = threading.Event(), threading.Event()
    last = threading.Event()

    def first() -> Edit:
        here.set()
        goes.wait()
        return Made("0", b"")

    def post(edit: Edit) -> None:
        done.append(edit)
        if len(done) == errands.MOST + 1:
            last.set()
    several = errands.Errands(post)
    assert several.send(first)
    here.wait()
    taken = [several.send(lambda k=k: Made(str(k), b"")) for k in range(1, errands.MOST + 3)]
    assert taken == [True] * errands.MOST + [False] * 2
    goes.set()
    last.wait()
    assert done == [Made(str(k), b"") for k in range(errands.MOST + 1)]
