"""Who presents or comes back has a place, one address leaves some to others, and a tab at rest gives its own back."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from client import WireTab, eventually
from websockets.exceptions import ConnectionClosed, InvalidStatus

from observer_lab.lessons import LESSONS
from observer_lab.page.access.places import SCARCE
from observer_lab.page.access.proxies import TrustedProxies
from observer_lab.page.access.tokens import PRESENTER_FIELD, AccessToken
from observer_lab.page.room.lecture_room import LectureRoom
from observer_lab.page.screen.server import LabServer
from observer_lab.page.web.html_page import REST

PLACES = 4
STIFFNESS = "stiffness error in the model [%]"
WORD = "a-word-of-the-presenter"


class Tab(WireTab):
    """A tab that waits for its place."""

    def enter(self) -> Tab:
        self.until(lambda: self.ticket, "its place")
        return self


def come(server: LabServer, address: str = "127.0.0.1", **options: str) -> Tab:
    """A tab of somebody behind the proxy of this machine."""
    return Tab(server.url, sender=address, **options).enter()


def page(server: LabServer, path: str = "/", **fields: str) -> int:
    """The status of the page for a browser that asks for it."""
    try:
        with urlopen(Request(server.url + path, headers=fields), timeout=10) as answer:
            return answer.status
    except HTTPError as refused:
        return refused.code


@pytest.fixture
def small() -> Iterator[LabServer]:
    server = LabServer(LESSONS, port=0, lesson="separation", max_sessions=PLACES)
    yield server
    server.stop()


def fill(server: LabServer, tabs: ExitStack) -> list[Tab]:
    """Tabs of as many addresses as there are places."""
    found = [tabs.enter_context(come(server, f"203.0.113.{k}")) for k in range(PLACES)]
    with pytest.raises(InvalidStatus):
        Tab(server.url)
    assert page(server) == 503
    return found  # type: ignore[return-value]


def test_one_address_leaves_places_to_others(small: LabServer) -> None:
    with ExitStack() as tabs:
        for _ in range(PLACES - PLACES // SCARCE):
            tabs.enter_context(come(small, "2001:db8::1"))
        for again in ("2001:db8::1", "2001:db8::2"):  # one network of IPv6
            with pytest.raises(InvalidStatus):
                Tab(small.url, sender=again)
            assert page(small, **{"X-Forwarded-For": again}) == 503
        tabs.enter_context(come(small, "2001:db8:0:1::1"))


def test_a_tab_that_comes_back_has_its_place_though_others_wait(small: LabServer) -> None:
    with ExitStack() as tabs:
        first = fill(small, tabs)[0]
        first.cut()
        eventually(lambda: len(small.sessions) == PLACES - 1, "the end of its session")
        assert page(small) == 503, "its place is kept"
        assert page(small, f"/?place={first.ticket}") == 200
        back = tabs.enter_context(come(small, "198.51.100.1", path=f"/?place={first.ticket}"))
        back.settle()
        assert back.ticket == first.ticket and page(small) == 503


def test_a_tab_takes_the_place_of_its_own_connection_that_is_silent(small: LabServer) -> None:
    with ExitStack() as tabs:
        first = fill(small, tabs)[1]
        back = tabs.enter_context(come(small, "203.0.113.1", path=f"/?place={first.ticket}"))
        assert first.closed() == 1011 and back.ticket == first.ticket
        eventually(lambda: len(small.sessions) == PLACES, "the end of the older session")
        with pytest.raises(InvalidStatus):
            Tab(small.url, path=f"/?place={first.ticket[:-1]}0" if first.ticket[-1] != "0" else f"/?place={first.ticket[:-1]}1")


def test_a_reload_finds_its_place_among_those_that_are_spare(small: LabServer) -> None:
    with ExitStack() as tabs:
        first = fill(small, tabs)[0]
        first.close()
        eventually(lambda: len(small.sessions) == PLACES - 1, "the end of its session")
        tabs.enter_context(come(small, "198.51.100.1"))  # somebody was quicker
        assert page(small) == 503 and page(small, f"/?place={first.ticket}") == 200
        tabs.enter_context(come(small, "203.0.113.0", path=f"/?place={first.ticket}"))


def test_who_presents_has_a_place_at_a_full_server(tmp_path: Path) -> None:
    room = LectureRoom(tmp_path, 0, "en")
    server = LabServer(LESSONS, port=0, lesson="separation", max_sessions=PLACES, room=room, mode="guide",
                       presenter=AccessToken(WORD, 0, PRESENTER_FIELD))
    cookie = f"observer-lab-0-{PRESENTER_FIELD}={WORD}"
    try:
        with ExitStack() as tabs:
            fill(server, tabs)
            assert page(server, Cookie=cookie) == 200 and page(server, Cookie=cookie + "x") == 503
            for _ in range(3):
                tabs.enter_context(come(server, "203.0.113.0", cookies=cookie)).settle()
            assert len(server.sessions) == 3 and page(server) == 503
            server._places._idle = 0.0  # whoever follows without a word from the presenter rests
            server._server.get_event_loop().call_soon_threadsafe(server._places.look)
            eventually(lambda: json.loads(urlopen(f"{server.url}/health", timeout=10).read())["tabs"] == 3, "the rest of the followers")
            assert len(server.sessions) == 3
    finally:
        server.stop()


def test_only_a_proxy_that_is_trusted_says_for_whom_it_asks() -> None:
    """The proxy of this machine is always trusted; here it names another one, which then names the browser."""
    server = LabServer(LESSONS, port=0, lesson="separation", max_sessions=PLACES, proxies=TrustedProxies.of(["10.0.0.0/8"]))
    try:
        with ExitStack() as tabs:
            for k in range(PLACES):
                tabs.enter_context(come(server, f"203.0.113.{k}, 10.0.0.1"))
    finally:
        server.stop()


def test_a_tab_that_nobody_touches_gives_its_place_back_and_returns_where_it_was(small: LabServer) -> None:
    with ExitStack() as tabs:
        one, *others = fill(small, tabs)
        one.update(STIFFNESS, value=7.0)
        one.settle()
        for tab in others:
            tab.settle()
        small._places._idle = 60.0
        look = partial(small._server.get_event_loop().call_soon_threadsafe, small._places.look)
        for held in small._places._tabs.values():
            assert held.connection is not None
            held.connection.touched -= 61.0
        for tab in others:
            tab.answered()  # somebody is there
        look()
        with pytest.raises(ConnectionClosed) as ended:
            while True:
                one._receive(0.1)
        assert ended.value.rcvd is not None and ended.value.rcvd.reason == REST
        eventually(lambda: len(small.sessions) == PLACES - 1, "the end of its session")
        tabs.enter_context(come(small, "198.51.100.1"))  # its place is free for others
        back = tabs.enter_context(come(small, "203.0.113.0", path=f"/?place={one.ticket}", kept=one.kept or ""))
        back.settle()
        assert back.value(STIFFNESS) == 7.0
        assert json.loads(urlopen(f"{small.url}/health", timeout=10).read())["tabs"] == PLACES + 1
