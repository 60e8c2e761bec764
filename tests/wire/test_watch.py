"""Lessons that fail, exit, loop, hoard or never come back: their tab gets one sentence, the others go on, nothing is left behind."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import pytest
from client import WireTab, empty, eventually
from sick import BLOCKS, EXITS, GOOD, HOARDS, LABEL, LOOPS, RAISES, Sick

from observer_lab.lessons import LESSONS
from observer_lab.page.screen.server import LabServer
from observer_lab.session.runtime import watchdog
from observer_lab.session.runtime.watchdog import TAB_ENDED, TOO_LONG, TOO_MUCH
from observer_lab.session.session import WATCHDOG

DELAY = "input delay [ms]"


@pytest.fixture(scope="module")
def sick() -> Sick:
    return Sick()


@pytest.fixture(scope="module")
def ward(sick: Sick) -> Iterator[LabServer]:
    server = LabServer({**LESSONS, GOOD.id: sick.lesson}, port=0, lesson=GOOD.id)
    yield server
    sick.back.set()
    server.stop()


@pytest.fixture
def enter(ward: LabServer) -> Iterator[Callable[[], WireTab]]:
    tabs: list[WireTab] = []

    def make() -> WireTab:
        tabs.append(WireTab(ward.url))
        tabs[-1].settle()
        return tabs[-1]
    yield make
    for tab in tabs:
        tab.close()
    empty(ward)


def workers() -> int:
    return sum(thread.name == "observer-lab session" for thread in threading.enumerate())


def test_a_sick_lesson_costs_its_own_tab_one_sentence_and_the_others_nothing(enter: Callable[[], WireTab], sick: Sick,
                                                                            monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watchdog, "LOOK_INTERVAL_S", 0.02)
    mine, other = enter(), enter()
    for value, name, limit, said in ((RAISES, "longest", 10.0, "division"), (EXITS, "longest", 10.0, "SystemExit"),
                                      (LOOPS, "longest", 0.3, TOO_LONG("en")), (HOARDS, "room", 5e6, TOO_MUCH("en"))):
        before, notes = other.value(DELAY), len(mine.notes)
        mine.update(LABEL, value=value)
        eventually(lambda v=value: sick.at == v, "the sick run")
        other.update(DELAY, value=before + 6.0)
        other.settle()  # while it loops: the limit is not yet reached
        with monkeypatch.context() as strict:
            strict.setattr(WATCHDOG, name, limit)
            mine.until(lambda s=said, n=notes: any(s in note for note in mine.notes[n:]), "the sentence")
        mine.until(lambda: mine.value(LABEL) == 0.0, "the good value")
        mine.settle()
        assert len(mine.notes) == notes + 1 and not other.notes and other.value(DELAY) == before + 6.0
    mine.update(LABEL, value=7.0)
    mine.settle()
    assert mine.value(LABEL) == 7.0


def test_a_run_that_never_comes_back_ends_its_tab_and_is_counted_until_it_does(enter: Callable[[], WireTab], sick: Sick, ward: LabServer,
                                                                              monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watchdog, "LOOK_INTERVAL_S", 0.02)
    before = workers()
    other, mine = enter(), enter()
    mine.update(LABEL, value=BLOCKS)
    eventually(lambda: sick.at == BLOCKS, "the sick run")
    other.update(DELAY, value=6.0)
    other.settle()
    with monkeypatch.context() as strict:
        strict.setattr(WATCHDOG, "asleep", 0.0)
        strict.setattr(WATCHDOG, "grace", 0.0)
        mine.until(lambda: TAB_ENDED("en") in mine.notes, "the sentence")
        assert mine.closed() == 1011
    eventually(lambda: len(ward.sessions) == 1, "a free place")
    assert ward.health()["stuck"] == WATCHDOG.stuck == 1
    other.update(DELAY, value=12.0)
    other.settle()
    sick.back.set()
    eventually(lambda: WATCHDOG.stuck == 0, "the end of the run")
    other.close()
    eventually(lambda: workers() <= before, "the end of the threads")


def test_a_tab_that_leaves_a_loop_behind_takes_it_along(enter: Callable[[], WireTab], sick: Sick, ward: LabServer,
                                                        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watchdog, "LOOK_INTERVAL_S", 0.02)
    monkeypatch.setattr(watchdog, "ABANDONED_STEP_CPU_S", 0.05)
    before, tab, sick.at = workers(), enter(), 0.0
    tab.update(LABEL, value=LOOPS)
    eventually(lambda: sick.at == LOOPS, "the loop")
    tab.close()
    eventually(lambda: workers() <= before, "the end of its thread")
    assert not WATCHDOG.stuck
