"""Floods cost their sender alone: it is dropped at a bound, with one kind of line in the log, and another tab goes on as before."""

from __future__ import annotations

import contextlib
import logging
import os
import resource
import socket
from collections.abc import Callable, Iterator
from importlib.metadata import version
from urllib.parse import urlsplit
from urllib.request import urlopen

import msgspec
import pytest
from client import WireTab, eventually
from websockets.exceptions import ConnectionClosed
from websockets.frames import Frame, Opcode

from observer_lab.lessons import LESSONS
from observer_lab.page.access import connection as connections
from observer_lab.page.access.addresses import listen
from observer_lab.page.access.flood_guard import EARLY_BURST, MAX_FRAGMENTS, MESSAGE_BURST
from observer_lab.page.screen.server import LabServer

STIFFNESS = "stiffness error in the model [%]"
POLICY_VIOLATION = 1008
MANY = int(2 * MESSAGE_BURST)


@pytest.fixture
def own() -> Iterator[LabServer]:
    """A server of its own: whoever floods must wait before it is let in again."""
    server = LabServer(LESSONS, port=0, lesson="separation")
    yield server
    server.stop()


def frames(opcode: Opcode, count: int, payload: bytes = b"", fin: bool = True) -> bytes:
    """So many frames as a browser would mask them."""
    return b"".join(Frame(opcode, payload, fin).serialize(mask=True) for _ in range(count))


COMMAND = msgspec.msgpack.encode({"type": "CommandTriggerMessage", "uuid": "nobody"})
CAMERA_LATER = msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": "nobody", "updates": {"value": 1}})
FLOODS = {
    "pings": frames(Opcode.PING, MANY, b"x" * 125),
    "pongs": frames(Opcode.PONG, MANY),
    "empty pieces": frames(Opcode.BINARY, 1, b"", False) + frames(Opcode.CONT, MAX_FRAGMENTS + 1, b"", False),
    "large pieces": frames(Opcode.BINARY, 1, b"", False) + frames(Opcode.CONT, MAX_FRAGMENTS + 1, b"x" * 1100, False),
    "commands for nobody": frames(Opcode.BINARY, MANY, COMMAND),
    "text": frames(Opcode.TEXT, MANY, b"text"),
    "empty messages": frames(Opcode.BINARY, MANY),
}


@pytest.mark.parametrize("looks", [False, True], ids=["before the camera", "with a tab"])
@pytest.mark.parametrize("kind", list(FLOODS))
def test_a_flood_ends_its_own_connection_and_no_other(own: LabServer, caplog: pytest.LogCaptureFixture, kind: str, looks: bool) -> None:
    with WireTab(own.url) as good:
        good.settle()
        bad = WireTab(own.url, camera=looks)
        if looks:
            bad.settle()
        with caplog.at_level(logging.WARNING), contextlib.suppress(OSError):
            bad._socket.socket.sendall(FLOODS[kind])
        assert bad.closed() in (POLICY_VIOLATION, 1006)
        eventually(lambda: len(own.sessions) == 1, "the end of the other session")
        assert [line for line in caplog.messages if "dropped a connection" in line]
        assert not [line for line in caplog.records if line.exc_info]
        good.update(STIFFNESS, value=7.0)
        good.until(lambda: good.value(STIFFNESS) == 7.0, "a good value")
        good.answered()


def test_a_connection_without_a_tab_may_send_a_few_messages(own: LabServer) -> None:
    with WireTab(own.url, camera=False) as early:
        for _ in range(int(EARLY_BURST) // 2):
            early.send_raw(CAMERA_LATER)
        early.look()
        early.settle()


def test_a_connection_that_opens_no_tab_is_dropped_in_time(own: LabServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connections, "TAB_TIMEOUT_S", 0.2)
    with WireTab(own.url) as good:
        good.settle()
        assert WireTab(own.url, camera=False).closed() == POLICY_VIOLATION
        good.answered()


def test_an_address_that_floods_again_and_again_must_wait(own: LabServer) -> None:
    refused = 0
    for _ in range(8):
        try:
            bad = WireTab(own.url, camera=False)
        except Exception as problem:
            refused += "429" in str(problem)
            continue
        with contextlib.suppress(OSError, ConnectionClosed):
            bad._socket.socket.sendall(FLOODS["text"])
        bad.closed()
    assert refused
    with urlopen(f"{own.url}/health", timeout=10) as health:
        assert health.status == 200, "pages and health checks of the address go on"


def test_frames_that_come_with_the_head_count_for_the_sender_whom_the_proxy_names(own: LabServer,
                                                                                    caplog: pytest.LogCaptureFixture) -> None:
    place = urlsplit(own.url)
    head = (f"GET / HTTP/1.1\r\nHost: {place.netloc}\r\nX-Forwarded-For: 198.51.100.7\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            f"Sec-WebSocket-Protocol: viser-v{version('viser')}\r\n\r\n").encode()
    with caplog.at_level(logging.WARNING):
        for _ in range(12):
            with socket.create_connection((place.hostname, place.port or 0), timeout=30) as plain, contextlib.suppress(OSError):
                plain.sendall(head + FLOODS["text"])
                while plain.recv(65536):
                    pass
    dropped = [line for line in caplog.messages if "dropped a connection" in line]
    assert dropped and all("198.51.100.7" in line for line in dropped)
    with WireTab(own.url) as good:
        good.settle()


def test_out_of_files_is_one_kind_of_line_and_passes(caplog: pytest.LogCaptureFixture) -> None:
    """The listener turns away whom it cannot hold; asyncio would report each place of its queue."""
    listener = listen("127.0.0.1", 0)
    now, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    with contextlib.ExitStack() as held, listener, caplog.at_level(logging.WARNING):
        callers = [held.enter_context(socket.create_connection(listener.getsockname())) for _ in range(3)]
        lowest = os.open(os.devnull, os.O_RDONLY)
        os.close(lowest)
        resource.setrlimit(resource.RLIMIT_NOFILE, (lowest, most))
        try:
            for _ in callers[1:]:
                with pytest.raises(ConnectionAbortedError):
                    listener.accept()
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, (now, most))
        connection, _ = listener.accept()
        connection.close()
        assert callers[0].recv(1) == callers[1].recv(1) == b""
    assert {record.getMessage() for record in caplog.records} == {"a connection was turned away: too many files are open"}


def test_a_page_of_another_version_is_one_line_of_our_log(own: LabServer, caplog: pytest.LogCaptureFixture,
                                                          capfd: pytest.CaptureFixture[str]) -> None:
    with caplog.at_level(logging.WARNING):
        assert WireTab(own.url, protocol="viser-v0.0.1", camera=False).closed() == 1002
    assert [line for line in caplog.messages if "another version" in line] and "mismatch" not in "".join(capfd.readouterr())


def test_what_a_stranger_sends_is_answered_while_many_open_and_say_nothing(own: LabServer, enter_many: Callable[[LabServer], None]) -> None:
    enter_many(own)
    with urlopen(f"{own.url}/health", timeout=10) as health:
        assert health.status == 200


@pytest.fixture
def enter_many() -> Iterator[Callable[[LabServer], None]]:
    """Opens connections that send nothing; closed after the test."""
    opened: list[socket.socket] = []

    def enter(server: LabServer) -> None:
        place = urlsplit(server.url)
        opened.extend(socket.create_connection((place.hostname, place.port), timeout=10) for _ in range(100))
    yield enter
    for one in opened:
        one.close()
