"""One server for a file of tests, on a free port of the loopback; tabs that are closed after each test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from client import WireTab, empty

from observer_lab.lessons import LESSONS
from observer_lab.page.screen.server import LabServer
from observer_lab.session.session import Session

LESSON = "separation"


@pytest.fixture(scope="module")
def server() -> Iterator[LabServer]:
    server = LabServer(LESSONS, port=0, lesson=LESSON)
    yield server
    server.stop()


@pytest.fixture
def enter(server: LabServer) -> Iterator[Callable[..., WireTab]]:
    """Makes a tab and waits for its first complete picture."""
    tabs: list[WireTab] = []

    def make(**options: Any) -> WireTab:
        tab = WireTab(server.url, **options)
        tabs.append(tab)
        tab.settle()
        return tab
    yield make
    for tab in tabs:
        tab.close()
    empty(server)


@pytest.fixture
def newest(server: LabServer) -> Callable[[], Session]:
    """The session of the tab that came last."""
    return lambda: server.sessions[max(server.sessions)]

