"""A long fit in the command line: how far it is, and Ctrl-C."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from observer_lab.cli.entry import main
from observer_lab.cli.records import SAID_AFTER_S, STOPPED, fit_told


def log(folder: Path) -> str:
    u = np.random.default_rng(0).choice([-1.0, 1.0], 300)
    x, rows = 0.0, ["t,u,y"]
    for k, push in enumerate(u):
        rows.append(f"{k},{push},{x:.5f}")
        x = 0.8 * x + push
    (folder / "log.csv").write_text("\n".join(rows))
    return str(folder / "log.csv")


def test_a_long_fit_says_how_far_it_is_and_a_short_one_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    now = [0.0]
    with fit_told(lambda: now[0]) as tell:
        for k in range(11):
            tell(k / 10)
    assert capsys.readouterr().err == ""
    with fit_told(lambda: now[0]) as tell:
        for k in range(1, 11):
            now[0] += 1.5 * SAID_AFTER_S
            tell(k / 10)
    said = capsys.readouterr().err
    assert "40 of 100 parts of the fit, 40 %, 9 s left" in said and said.count("\n") >= 8


def test_ctrl_c_in_a_fit_leaves_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed(*_: object, progress: object = None, **__: object) -> None:
        raise KeyboardInterrupt
    monkeypatch.setattr(import_module("observer_lab.lessons.record.own"), "identify", pressed)
    figure = tmp_path / "figure.svg"
    assert main(["run", "record", "--data", log(tmp_path), "--figure", str(figure)]) == 130
    found = capsys.readouterr()
    assert found.err == STOPPED + "\n" and found.out == "" and not figure.exists()
