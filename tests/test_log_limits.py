"""The log: one line for everything, at a bounded rate, with what was left out counted."""

from __future__ import annotations

import asyncio
import io
import json
import logging
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from typing import Any, cast

import pytest

from observer_lab.classroom.kept_room import VoteWriter
from observer_lab.cli.logs import LINES_AT_ONCE, SECONDS_PER_LINE, OneLine, OneLineOfJson, RateLimit, set_up
from observer_lab.page.room.broadcast import Broadcast
from observer_lab.page.room.relay import Feed, Relay
from observer_lab.page.viser_private.message_transport import log_failed_callback
from observer_lab.session.state.view import Picture


def record(words: str, *values: object, level: int = logging.WARNING) -> logging.LogRecord:
    return logging.LogRecord("lab", level, "", 0, words, values, None)


def test_a_kind_of_line_has_a_rate_and_what_was_left_out_is_counted() -> None:
    now = 0.0
    limit = RateLimit(lambda: now)
    passed = [limit.filter(record("refused: %s", k)) for k in range(100)]
    assert sum(passed) == LINES_AT_ONCE and all(passed[: int(LINES_AT_ONCE)])
    assert limit.filter(record("another kind")) and limit.filter(record("refused: %s", 0, level=logging.INFO))
    now = SECONDS_PER_LINE
    late = record("refused: %s", "evil.example")
    assert limit.filter(late) and late.getMessage() == f"refused: evil.example (and {100 - LINES_AT_ONCE:.0f} more like it)"
    assert limit.filter(late), "every handler hears the same decision"
    assert not limit.filter(record("refused: %s", 1))


@pytest.mark.parametrize("formatter", [OneLine("%(message)s"), OneLineOfJson(1)], ids=["plain", "json"])
def test_a_record_is_one_line_whatever_is_in_it(formatter: logging.Formatter) -> None:
    try:
        raise ValueError("two\nlines")
    except ValueError as problem:
        odd = record("refused: %s", "a\r\nforged line\u2028x \ud800")
        odd.exc_info = (type(problem), problem, problem.__traceback__)
    line = formatter.format(odd)
    assert len(line.splitlines()) == 1 or formatter.__class__ is OneLineOfJson
    assert "\n" not in line and "\r" not in line and "ValueError" in line
    line.encode("utf-8")


@pytest.fixture
def told() -> Iterator[io.StringIO]:
    """What goes to the terminal of a server."""
    before, hook = logging.getLogger().handlers[:], threading.excepthook
    level = logging.getLogger().level
    set_up(True, None)
    handler = logging.getLogger().handlers[0]
    assert isinstance(handler, logging.StreamHandler)
    handler.stream = stream = io.StringIO()
    yield stream
    logging.captureWarnings(False)
    logging.getLogger().handlers[:] = before
    logging.getLogger().setLevel(level)
    threading.excepthook = hook


class Gone:
    """A store whose server is gone: whatever is asked of it fails, and after so many failures somebody is told."""

    def __init__(self, failures: int) -> None:
        self._left, self.failed = failures, threading.Event()

    def __getattr__(self, name: str) -> Any:
        self._left -= 1
        if self._left <= 0:
            self.failed.set()
        raise ConnectionError(name)


def relay_without(store: Any) -> Callable[[], object]:
    loop = asyncio.new_event_loop()
    loop.close()
    relay = Relay(store, loop, poll=0.0)
    relay._feeds["en-wide"] = Feed("en-wide", None)
    relay.start()
    assert store.failed.wait(60)
    return relay.close


def writer_without(store: Any) -> Callable[[], object]:
    writer, told = VoteWriter(store), threading.Semaphore(0)
    writer.start()
    while not store.failed.is_set():
        writer.cast(1, "ballot0001", 0, lambda _: told.release())
        assert told.acquire(timeout=60)
    return writer.close


def broadcast_without(store: Any) -> Callable[[], object]:
    broadcast = Broadcast(store, lambda: None, lambda _: None, lambda: None)
    broadcast._picture = cast(Picture, object())
    broadcast.start()
    while not store.failed.wait(0.001):
        broadcast.notice()
    return broadcast.close


@pytest.mark.parametrize("loop", [relay_without, writer_without, broadcast_without])
def test_a_room_whose_store_is_gone_fails_again_and_again_and_says_so_at_the_bounded_rate(
        told: io.StringIO, loop: Callable[[Any], Callable[[], object]]) -> None:
    begun, before = time.monotonic(), set(threading.enumerate())
    loop(Gone(10 * int(LINES_AT_ONCE)))()
    for thread in set(threading.enumerate()) - before:
        thread.join(60)
    most = LINES_AT_ONCE + (time.monotonic() - begun) / SECONDS_PER_LINE + 1
    assert 0 < len(told.getvalue().splitlines()) <= most


def test_what_libraries_print_comes_as_lines_of_json(told: io.StringIO) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        logging.captureWarnings(False)  # pytest has put its own hook in since the fixture
        logging.captureWarnings(True)
        warnings.warn("of a library", stacklevel=1)
    thread = threading.Thread(target=lambda: 1 / 0)
    thread.start()
    thread.join()
    log_failed_callback(KeyError("x"))
    lines = [json.loads(line) for line in told.getvalue().splitlines()]
    assert [line["level"] for line in lines] == ["warning", "error", "error"]
    assert "of a library" in lines[0]["what"] and "ZeroDivisionError" in lines[1]["trace"] and "KeyError" in lines[2]["trace"]
