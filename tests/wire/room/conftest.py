"""A room of its own for each test, which no test before has left in another scene or with an open vote; its server starts in 40 ms."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from client import WireTab, empty
from lecture import PREDICT, Enter, Present, ask, card, opened

from observer_lab.classroom.room_store import RoomStore
from observer_lab.page.screen.server import LabServer


@pytest.fixture
def server(tmp_path: Path) -> Iterator[LabServer]:
    server = opened(tmp_path)
    yield server
    server.stop()


@pytest.fixture
def enter(server: LabServer) -> Iterator[Enter]:
    """Makes a tab; it waits for nothing."""
    tabs: list[WireTab] = []

    def make(**options: object) -> WireTab:
        tabs.append(WireTab(server.url, **options))  # type: ignore[arg-type]
        return tabs[-1]
    yield make
    for tab in tabs:
        tab.close()
    empty(server)


@pytest.fixture
def present(enter: Enter, tmp_path: Path) -> Present:
    """Makes a tab that presents the scene of the first question."""
    def make() -> WireTab:
        tab = enter(word=RoomStore(tmp_path).secret)
        tab.settle()
        ask(tab, f"scene:{PREDICT}")
        tab.until(lambda: 'data-scene="predict"' in card(tab), "the question's scene")
        tab.settle()
        return tab
    return make
