"""The lab behind nginx by the recipes that we ship: token, LTI launch and upload, a room, and as many sockets as a room may have."""

from __future__ import annotations

import asyncio
import os
import re
import signal
import ssl
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import urljoin, urlsplit

import pytest
from client import WireTab
from course_makers import word
from lecture import card, counts
from lti_platform import LearningBrowser, LearningPlatform, page_of, pem
from nginx_proxy import NAME, free_ports, nginx
from served import Served
from test_wire_plants import MOTOR, send_file

from observer_lab.cli.commands.serve import ROOM_TABS
from observer_lab.cli.courses import course_in
from observer_lab.page.access.request_head import MAX_FORM_BYTES
from observer_lab.page.words import phrases

COURSE = 'course = "c"\nsecret = "a secret of a course, for tests alone"\n[[lessons]]\nlesson = "separation"\nexams = ["offset"]\n'
WORD = "a-word-of-this-test"
ANY_CERTIFICATE = ssl._create_unverified_context()


@contextmanager
def served(place: Path, ports: list[int], *options: str, until: str = "") -> Iterator[str]:
    """A lab behind nginx; what it prints up to a line that begins so."""
    command = [sys.executable, "-m", "observer_lab", "serve", "--port", str(ports[0]), "--exact-port", *options]
    with nginx(place, *ports, "localhost"), Served(command, cwd=place, text=True, env={**os.environ, "OBSERVER_LAB_TOKEN": WORD},
                                                   stdout=subprocess.PIPE) as server:
        assert server.stdout is not None
        printed = [server.stdout.readline()]
        while not printed[-1].startswith(until):
            printed.append(server.stdout.readline())
        yield "".join(printed)
        server.send_signal(signal.SIGINT)
        server.communicate(timeout=60)


def tab_at(url: str, browser: LearningBrowser, path: str = "") -> WireTab:
    return WireTab(url, origin=url, path=path, cookies=browser.cookie_line, tls=ANY_CERTIFICATE)


def test_token_launches_hand_in_and_upload_go_through_the_proxy(tmp_path: Path) -> None:
    platform = LearningPlatform()
    (tmp_path / "lab.pem").write_text(pem("lab"), encoding="utf-8")
    (tmp_path / "course.toml").write_text(COURSE, encoding="utf-8")
    ports = free_ports(3)
    url = f"https://localhost:{ports[-1]}"
    (tmp_path / "platforms.toml").write_text(platform.toml(url), encoding="utf-8")
    with served(tmp_path, ports, "--lti", "platforms.toml", "--course", "course.toml", "--data-dir", "kept", "--lesson", "separation",
                "--view", "lab"):
        stranger = LearningBrowser(url)
        assert stranger.ask("/").status == 401
        assert stranger.ask(f"/?token={WORD}").status in (302, 303) and stranger.ask("/health").status == 200
        with tab_at(url, stranger) as tab:
            tab.settle()
            send_file(tab, "motor.json", MOTOR)
            tab.until(lambda: any(name.startswith("/plant/tube") for name in tab.nodes), "the uploaded plant")
        platform.trust(url)
        pupil = LearningBrowser(url)
        for number in range(8):  # more than a browser keeps: the head of the answer is as long as it gets
            answer = platform.launch(pupil, "separation", f"user-{number}", resource_link={"id": f"link-{number}"}, junk="x" * 3000)
            assert answer.status == 303, answer.text
        with tab_at(url, pupil, f"/?{urlsplit(page_of(pupil, answer)).query}") as tab:
            tab.settle()
            tab.update("answer", value="3")
            tab.press("hand in")
            tab.until(lambda: phrases.POINTS_SENT("en") in tab.notes, "the points")
        with tab_at(url, stranger) as tab:  # who was not launched hands in with a key and its word
            tab.update("your key", value="s1")
            tab.update("your word", value=word(course_in(str(tmp_path / "course.toml")), "s1"))
            tab.update("answer", value="3")
            tab.press("hand in")
            tab.until(lambda: any("Signed" in note for note in tab.notes), "the signature")
        assert platform.begin(LearningBrowser(url), post=True)["state"]
        long = {"id_token": "x" * (MAX_FORM_BYTES - 2000), "state": "s"}
        assert LearningBrowser(url).ask("/lti/launch", long).status == 403, "the lab answers, and not the proxy"
    assert WORD not in (tmp_path / "observer-lab.log").read_text(encoding="utf-8") and platform.state.scores
    platform.close()


def test_a_room_goes_through_the_proxy(tmp_path: Path) -> None:
    ports = free_ports(3)
    url = f"https://localhost:{ports[-1]}"
    with served(tmp_path, ports, "--room", "--at", f"{url}/", "--lesson", "separation", until="Audience") as printed:
        secret = re.search(r"present=([\w-]+)", printed)
        assert secret is not None, printed
        presenter, phone = LearningBrowser(url), LearningBrowser(url)
        for browser, path in ((presenter, f"/?token={WORD}&present={secret[1]}"), (phone, f"/?token={WORD}")):
            while (answer := browser.ask(path)).status in (302, 303):
                path = urlsplit(urljoin(f"{url}/", answer.field("Location"))).path + "?" + urlsplit(answer.field("Location")).query
        with tab_at(url, presenter) as leads, tab_at(url, phone) as follows:
            leads.settle()
            follows.until(lambda: card(follows), "the scene")
            leads.until(lambda: counts(leads), "the class")


def test_the_proxy_holds_every_socket_of_a_full_room(tmp_path: Path) -> None:
    """In the place of the lab stands one that only opens sockets."""
    lab, plain, tls = free_ports(3)

    async def open_socket(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with suppress(asyncio.CancelledError):  # asyncio asks this task for its error when it ends, and a cancelled one raises there
            await reader.readuntil(b"\r\n\r\n")
            writer.write(b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\nopen")
            while data := await reader.read(100):
                writer.write(data)
            writer.close()

    async def page(crowd: asyncio.Semaphore) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        async with crowd:
            reader, writer = await asyncio.open_connection("127.0.0.1", tls, ssl=ANY_CERTIFICATE, server_hostname=NAME)
            writer.write(f"GET / HTTP/1.1\r\nHost: {NAME}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n".encode())
            assert b" 101 " in await reader.readline()
            await reader.readuntil(b"open")
            return reader, writer

    async def hall() -> int:
        async with await asyncio.start_server(open_socket, "127.0.0.1", lab, backlog=1000):
            crowd = asyncio.Semaphore(40)
            pages = await asyncio.gather(*(page(crowd) for _ in range(ROOM_TABS)))
            for _, writer in pages:
                writer.write(b"x")
            heard = [await reader.readexactly(1) for reader, _ in pages]
            for _, writer in pages:
                writer.close()
            return heard.count(b"x")
    with nginx(tmp_path, lab, plain, tls):
        assert asyncio.run(asyncio.wait_for(hall(), 120)) == ROOM_TABS


@pytest.mark.parametrize("path", ["/", "/lti/launch"])
def test_without_tls_one_is_sent_to_it_without_the_token(tmp_path: Path, path: str) -> None:
    lab, plain, tls = free_ports(3)
    with nginx(tmp_path, lab, plain, tls, "localhost"):
        answer = LearningBrowser(f"http://localhost:{plain}").ask(f"{path}?token=word")
    assert (answer.status, answer.field("Location")) == (308, f"https://localhost:{tls}{path}")
