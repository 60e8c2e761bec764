"""The log: one line for everything, at a bounded rate, with what was left out counted."""

from __future__ import annotations

import io
import json
import logging
import threading
import warnings
from collections.abc import Iterator

import pytest

from observer_lab.cli.log_limits import LINES_AT_ONCE, SECONDS_PER_LINE, OneLine, RateLimit
from observer_lab.cli.logs import OneLineOfJson, set_up
from observer_lab.page.viser_private.message_transport import log_failed_callback


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


def test_what_libraries_print_comes_as_lines_of_json(told: io.StringIO) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        logging.captureWarnings(False)  # pytest has put its own hook in since the fixture
        logging.captureWarnings(True)
        warnings.warn("of a library", stacklevel=1)
    thread = threading.Thread(target=lambda: 1 / 0)
    thread.start()
    thread.join()
    log_failed_callback(KeyError, KeyError("x"), None)
    lines = [json.loads(line) for line in told.getvalue().splitlines()]
    assert [line["level"] for line in lines] == ["warning", "error", "error"]
    assert "of a library" in lines[0]["what"] and "ZeroDivisionError" in lines[1]["trace"] and "KeyError" in lines[2]["trace"]
