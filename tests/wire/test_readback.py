"""What a hand sets is never overwritten by an older value of its own, however slow the server is."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from client import WireTab

from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.lessons import LESSONS
from observer_lab.page.screen.server import LabServer

STIFFNESS, LIMITED = "stiffness error in the model [%]", "limit the coils"
SLOW = 0.2  # s that a draft takes: several values of a quick hand come while one is computed
QUICK = 0.06  # s between two values of the hand: the page sends no faster


def slow(lesson: Lesson) -> Lesson:
    """The lesson on a machine that has little time for it."""
    def compute(design: Design) -> Outcome:
        time.sleep(SLOW)
        return lesson.compute(design)
    return replace(lesson, compute=compute)


@pytest.fixture(scope="module")
def server() -> Iterator[LabServer]:
    server = LabServer({"separation": slow(LESSONS["separation"])}, port=0, lesson="separation")
    yield server
    server.stop()


def by_hand(tab: WireTab, label: str, values: list[Any]) -> list[Any]:
    """Set one value after the other, as a hand does; the values that came back over them."""
    uuid, came = tab.find(label), []
    for value in values:
        before = len(tab.messages)
        tab.update(label, value=value)
        tab.pass_time(QUICK)
        came += [m["updates"]["value"] for m in tab.messages[before:]
                 if m["type"] == "GuiUpdateMessage" and m["uuid"] == uuid and "value" in m["updates"]]
    return came


HANDS: list[tuple[str, list[Any]]] = [
    (STIFFNESS, [float(v) for v in range(1, 17)]),
    (LIMITED, [k % 2 == 0 for k in range(16)]),
    ("q1", [(-14.0 - 0.123456 * k, 2.0) for k in range(16)]),
    ("time t [s]", [0.1 * k for k in range(16)]),
]


@pytest.mark.parametrize("label, values", HANDS, ids=[label for label, _ in HANDS])
def test_a_quick_hand_on_a_slow_server_never_meets_an_older_value_of_its_own(enter: Any, label: str, values: list[Any]) -> None:
    tab = enter()
    tab.press("skip")  # the run unlocks
    tab.press("‖ pause")
    tab.settle()
    assert by_hand(tab, label, values) == []
    tab.settle()
    assert tab.value(label) == pytest.approx(values[-1], abs=1e-3)


def test_the_run_does_not_come_back_over_the_hand_that_seeks_it(enter: Any) -> None:
    """The clock has written the slider; the hand's next value is not written back over it before the hand rests."""
    tab = enter()
    tab.press("skip")
    tab.settle()
    tab.press("‖ pause")
    tab.settle()
    uuid = tab.find("time t [s]")
    for t in (0.1, 0.3, 0.2):
        before = len(tab.messages)
        tab.update("time t [s]", value=t)
        tab.answered()
        assert [m for m in tab.messages[before:] if m.get("uuid") == uuid and "value" in m.get("updates", {})] == []
    tab.settle()
    assert tab.value("time t [s]") == pytest.approx(0.2, abs=1e-3)


def test_what_crosses_with_an_undo_is_shown_in_the_end(enter: Any, newest: Any) -> None:
    """A hand that goes on while an undo is under way: the widget and the design agree when all rests."""
    tab = enter()
    tab.update(STIFFNESS, value=5.0)
    tab.settle()
    tab.command("Undo")
    tab.update(STIFFNESS, value=6.0)  # sent before the undo is seen
    tab.settle()
    assert tab.value(STIFFNESS) == newest().picture.design["stiffness_error"] == 6.0


def test_a_refused_value_is_put_back_after_a_quick_hand(enter: Any, newest: Any) -> None:
    tab = enter()
    assert by_hand(tab, STIFFNESS, [3.0, 4.0]) == []
    tab.update(STIFFNESS, value=1e9)
    tab.settle()
    assert tab.value(STIFFNESS) == newest().picture.design["stiffness_error"]
    assert tab.value(STIFFNESS) in (3.0, 4.0), "what was accepted last"


def test_the_rows_of_poles_keep_what_a_quick_hand_typed_into_each(enter: Any, newest: Any) -> None:
    tab = enter()
    rows = [label for label in ("q1", "q2", "q3") if tab.widgets[tab.find(label)]["props"]["visible"]]
    wanted = {(real - 1.0, imag) for real, imag in (tab.value(row) for row in rows)}
    assert len(rows) > 1
    for row in rows:
        real, imag = tab.value(row)
        tab.update(row, value=(real - 1.0, imag))
    tab.settle()
    assert {tuple(tab.value(row)) for row in rows} == wanted
    assert {(p.real, p.imag) for p in newest().picture.design["observer_poles"] if p.imag >= 0} == wanted
