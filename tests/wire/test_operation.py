"""A server that is looked after: it says how it is, and tells its tabs when it stops."""

from __future__ import annotations

import json
import urllib.request
from collections.abc import Callable

from client import WireTab

from observer_lab.lessons import LESSONS
from observer_lab.page.screen.server import LabServer
from observer_lab.page.words import phrases


def health(server: LabServer) -> dict[str, object]:
    with urllib.request.urlopen(server.url + "/health", timeout=20) as answer:
        assert answer.headers["Content-Type"] == "application/json" and answer.headers["Cache-Control"] == "no-store"
        return json.loads(answer.read())


def test_health_counts_the_tabs_and_names_nobody(server: LabServer, enter: Callable[..., WireTab]) -> None:
    before = health(server)
    enter()
    after = health(server)
    assert before["status"] == after["status"] == "ok" and before["tabs"] == 0 and after["tabs"] == 1 and after["stuck"] == 0
    assert set(after) == {"status", "version", "tabs", "most_tabs", "kept_places", "stuck", "seconds", "resident_bytes", "lag_s"}


def test_a_server_that_stops_tells_its_tabs_first() -> None:
    server = LabServer(LESSONS, port=0, lesson="duality")
    with WireTab(server.url) as tab:
        tab.answered()
        server.stop()
        tab.until(lambda: phrases.STOPPED("en") in tab.notes, "the last word")
        assert tab.closed() is not None
