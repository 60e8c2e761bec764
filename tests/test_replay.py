"""A run as a page of its own: read as a browser reads it, refused in one sentence."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from all_replays import check
from commands import refused

from observer_lab.cli import inputs
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.style_sheet import clock
from observer_lab.page.replay.transport import slider_value

NETWORK = LESSONS["network"]


@pytest.mark.slow
def test_what_moves_on_the_page_stands_where_the_body_has_it() -> None:
    """In one lesson; in every one: python tests/lessons/all_replays.py"""
    check(LESSONS["saturation"], "zh")


def test_what_cannot_be_played_or_written_is_one_sentence(capsys: pytest.CaptureFixture[str], tmp_path: Path,
                                                          monkeypatch: pytest.MonkeyPatch) -> None:
    assert "does not end in .html" in refused(capsys, "replay", "network", "-o", "run.png")
    assert "no lesson nothing" in refused(capsys, "replay", "nothing")
    still = replace(NETWORK, compute=lambda design: replace(NETWORK.compute(design), stage=None))
    with monkeypatch.context() as patched:
        patched.setattr(inputs, "all_lessons", lambda: {"network": still})
        assert "no run in time" in refused(capsys, "replay", "network", "-o", str(tmp_path / "run.html"))
    monkeypatch.setattr("observer_lab.page.replay.replay.replay", lambda *_: "<html>")
    assert "cannot be written" in refused(capsys, "replay", "network", "-o", str(tmp_path / "nowhere" / "run.html"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("eighths", range(0, 81, 3))
def test_clock_and_slider_halfway_are_those_of_the_scripts(eighths: int) -> None:
    """Scripts round as ECMAScript says: of two that are equally near the larger one; Python's own round takes the even one."""
    t, horizon = eighths / 8, 10.0
    wanted = f"{(eighths * 1000 // 8 + 5) // 10 / 100:.2f}"
    assert f"t = {wanted} s" in clock(t, horizon, 1.0, "")
    assert slider_value(t, 0.25, horizon) == min((eighths + 1) // 2 / 4, horizon)
    assert slider_value(0.225, 0.01, horizon) == 0.23
