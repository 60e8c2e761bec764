"""A hand that is quicker than the server: no step is lost and nothing jumps back, in the browser itself."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest
from tab import Tab

from observer_lab.course.lesson import Design, Outcome
from observer_lab.lessons import LESSONS
from observer_lab.page.screen.server import LabServer
from observer_lab.session.state import history

SLIDER = "stiffness error in the model [%]"
SLOW = 0.3  # s that a draft takes: several steps of the hand come while one is computed
STEPS = 16


def slowly(design: Design) -> Outcome:
    """What the lesson computes, on a machine with little time for it."""
    time.sleep(SLOW)
    return LESSONS["separation"].compute(design)


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    server = LabServer({"separation": replace(LESSONS["separation"], compute=slowly)}, port=0, lesson="separation")
    yield server.url
    server.stop()


def test_every_step_of_a_quick_hand_arrives_on_a_slow_server(new_tab: Callable[..., Tab], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(history, "MERGE_WINDOW_S", 1e6)  # s: what is quick is not for a busy machine to say
    tab = new_tab(own=True)
    tab.thumb(SLIDER).focus()
    seen = []
    for _ in range(STEPS):
        tab.quick_keys("ArrowRight", 1)
        seen.append(tab.value(SLIDER))
    assert seen == [float(k + 1) for k in range(STEPS)]
    tab.answered(rests=True)
    assert tab.value(SLIDER) == STEPS
    tab.page.evaluate("document.activeElement.blur()")
    tab.key("z")
    tab.answered(rests=True)
    assert tab.value(SLIDER) == 0.0, "a quick hand is one step of undo"


def test_a_hand_that_pauses_between_steps_loses_none(new_tab: Callable[..., Tab]) -> None:
    """Steps that come while the final picture of an earlier one is on its way."""
    tab = new_tab(own=True)
    tab.thumb(SLIDER).focus()
    for k in range(8):
        tab.quick_keys("ArrowRight", 1)
        for _ in range(k):
            tab.sent()
    tab.answered(rests=True)
    assert tab.value(SLIDER) == 8.0
