"""What a browser is sent, its own tab's thread sends: two that write to one page at once take it apart under each other's hands."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from client import WireTab
from test_wire_plants import MOTOR, send_file
from viser.infra._async_message_buffer import AsyncMessageBuffer

from observer_lab.lessons import LESSONS

WORKER = "observer-lab session"
TOO_LATE = "// missed.js\n"  # what came for a widget that is gone: the server's loop sends it back, and the page does it again
BY_ITSELF = {"FileTransferPartAck", "RemoveNotificationMessage"}  # said to a browser that sends a file, before anything is done with it


@pytest.fixture
def senders(monkeypatch: pytest.MonkeyPatch) -> Iterator[set[tuple[str, str]]]:
    """Which kinds of messages which threads send from now on."""
    seen, push = set[tuple[str, str]](), AsyncMessageBuffer.push

    def watched(buffer: AsyncMessageBuffer, message: Any) -> None:
        late = TOO_LATE in getattr(message, "source", "")
        if type(message).__name__ not in BY_ITSELF and not late and message.excluded_self_client is None:  # else it is for other tabs
            seen.add((threading.current_thread().name, type(message).__name__))
        push(buffer, message)
    monkeypatch.setattr(AsyncMessageBuffer, "push", watched)
    yield seen


def shapes(tab: WireTab) -> None:
    """Windows of every shape, while lessons change: those with a map, with two boards, with none."""
    for k, lesson in enumerate(("saturation", "duality", "virtual-sensor", "separation")):
        tab.update("lesson", value=LESSONS[lesson].words["en"].title)
        for across, up in ((390, 844), (1920, 1080), (900, 560), (700 + 150 * k, 700)):
            tab.look(across, up)
        tab.settle()
        tab.look(390, 844)
        tab.look(1366, 768)
        tab.settle()


def dialogs(tab: WireTab) -> None:
    for name in ("Take it with you", "All lessons", "This list"):
        tab.command(name)
        tab.settle()
        tab.press("close")
        tab.settle()


def by_hand(tab: WireTab) -> None:
    tab.press("A")
    tab.update("name", value="mine")
    tab.press("pin this design")
    tab.settle()
    grips = next(name for name in tab.nodes if name.endswith("/grips"))
    for phase, dx in (("start", 0.0), ("move", 0.1), ("end", 0.2)):
        tab.drag(grips, phase, dx)
    tab.settle()
    send_file(tab, "motor.json", MOTOR)
    tab.settle()


@pytest.mark.parametrize("does", [shapes, dialogs, by_hand])
def test_only_a_tabs_own_thread_writes_to_its_page(does: Callable[[WireTab], None], enter: Callable[..., WireTab],
                                                   senders: set[tuple[str, str]]) -> None:
    tab = enter()
    senders.clear()
    does(tab)
    assert senders and {who for who, _ in senders} == {WORKER}, sorted(pair for pair in senders if pair[0] != WORKER)
