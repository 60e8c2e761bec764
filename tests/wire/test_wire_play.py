"""A page that plays by itself is given ahead of time just what a script is sent pose by pose, and then is left alone."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
from client import CALLED, WireTab

from observer_lab.page.viser_private.stage_frames import PROPERTY_KINDS, UNITS_PER_STAGE_UNIT, WHOLE_NUMBERS
from observer_lab.session.session import Session

Enter = Callable[..., WireTab]
Newest = Callable[[], Session]
MOVES = {"SetPositionMessage": "position", "SetOrientationMessage": "wxyz"}


def chunks(tab: WireTab, since: int = 0) -> list[dict[str, Any]]:
    """What the page was told to play, and when it was told to stop."""
    told = [CALLED.fullmatch(m["source"]) for m in tab.messages[since:] if m["type"] == "RunJavascriptMessage"]
    return [json.loads(call[2]) for call in told if call is not None and call[1] == "play"]


def played(tab: WireTab, since: int) -> dict[float, dict[tuple[str, str], list[float]]]:
    """By the time of the run: where everything stands, as a page finds out that takes all frames in order."""
    out: dict[float, dict[tuple[str, str], list[float]]] = {}
    stands: dict[tuple[str, str], list[float]] = {}
    for chunk in chunks(tab, since):
        for time, move in zip(chunk.get("times", ()), json.loads(chunk.get("moves", "[]")), strict=True):
            while move:
                node, kind, many = move[:3]
                fine = 1 if PROPERTY_KINDS[kind] in WHOLE_NUMBERS else UNITS_PER_STAGE_UNIT
                stands[chunk["names"][node], PROPERTY_KINDS[kind]] = [number / fine for number in move[3:3 + many]]
                move = move[3 + many:]
            out[time] = dict(stands)
    return out


def ends(session: Session) -> bool:
    picture = session.picture
    return picture is not None and not picture.state.moving


def test_a_page_that_plays_is_told_the_run_and_nothing_else(enter: Enter, newest: Newest) -> None:
    tab = enter(plays=True)
    tab.press("faster")
    tab.press("faster")
    before, session = len(tab.messages), newest()
    tab.press("skip")
    tab.until(lambda: session.picture is not None and session.picture.state.moving, "the run's begin")
    tab.until(lambda: ends(session), "the run's end")
    tab.settle()
    picture = session.picture
    assert picture is not None and picture.outcome.stage is not None
    stage, body = picture.outcome.stage, picture.outcome.stage.body
    told, frames = chunks(tab, before), played(tab, before)
    assert max(frames) == picture.end and 2 <= len(told) <= 4 and told[-1] == {"stop": True}
    scripts = [k for k, m in enumerate(tab.messages) if k >= before and str(m.get("source")).startswith("// play.js")]
    assert not any(m["type"] in MOVES for m in tab.messages[scripts[0]:scripts[-1]])
    for time, stands in list(frames.items())[::20]:
        index = max(0, int(np.searchsorted(stage.t, time + 1e-9, side="right")) - 1)
        for name, pose in body.pose(stage.x[index].tolist(), body.gain).items():
            assert np.allclose(stands[f"/plant/{name}", "position"], pose.position, atol=1 / UNITS_PER_STAGE_UNIT)
            assert np.allclose(stands[f"/plant/{name}", "wxyz"], pose.wxyz, atol=1 / UNITS_PER_STAGE_UNIT)
    steps = np.diff(list(frames))
    assert np.all(steps > 0) and steps.max() <= picture.rate / 30 * (1 + 1e-6)
    tab.until(lambda: tab.unasked() == [], "silence")


def test_a_run_that_is_stopped_in_the_middle_stands_where_its_clock_stands(enter: Enter, newest: Newest) -> None:
    """The page's own frames are taken back, and every part, the clock and the slider are sent, whatever stood there before."""
    tab = enter(plays=True)
    before, session = len(tab.messages), newest()
    tab.press("skip")
    tab.until(lambda: chunks(tab, before), "frames")
    since = len(tab.messages)
    tab.press("‖ pause")
    tab.settle()
    picture = session.picture
    assert picture is not None and picture.outcome.stage is not None and not picture.state.moving and 0 < picture.state.t < picture.end
    assert {"stop": True} in chunks(tab, since)
    sent = {(m["name"], MOVES[m["type"]]): m[MOVES[m["type"]]] for m in tab.messages[since:] if m["type"] in MOVES}
    stage = picture.outcome.stage
    index = max(0, int(np.searchsorted(stage.t, picture.state.t + 1e-9, side="right")) - 1)
    for name, pose in stage.body.pose(stage.x[index].tolist(), stage.body.gain).items():
        assert np.allclose(sent[f"/plant/{name}", "position"], pose.position) and np.allclose(sent[f"/plant/{name}", "wxyz"], pose.wxyz)
    clocks = [m["updates"]["content"] for m in tab.messages[since:] if 'ol-note ol-clock' in str(m.get("updates", {}).get("content"))]
    assert f"t = {picture.state.t:.2f} s" in clocks[-1]
    assert not any("<style" in words for words in clocks), "a rule that changes makes the browser look through its whole page anew"
    assert tab.unasked() == []


def test_a_script_is_sent_every_pose(enter: Enter) -> None:
    tab = enter()
    before = len(tab.messages)
    tab.press("skip")
    tab.until(lambda: sum(m["type"] in MOVES for m in tab.messages[before:]) > 60, "poses")
    assert not chunks(tab, before)
