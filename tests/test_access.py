"""Who knows the access token comes in, and nobody else; places and connections are counted right by several together."""

from __future__ import annotations

import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from http import HTTPStatus
from ipaddress import IPv6Address, ip_address
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from laws import each
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from observer_lab.engine.kernels import compile_cache
from observer_lab.page.access.access_policy import AccessPolicy
from observer_lab.page.access.handshake import AdmissionControl, PackedPage
from observer_lab.page.access.page_headers import PageHeaders
from observer_lab.page.access.places import Place, Visitor
from observer_lab.page.access.proxies import TrustedProxies, counted_address
from observer_lab.page.access.shared_counters import SharedCounters, WorkerSlot
from observer_lab.page.access.socket_handoff import HandedListener, HandedSocket, send_connection
from observer_lab.page.access.tokens import TOKEN_BYTES, AccessToken, draw_token
from observer_lab.page.web.html_page import token_required_page
from observer_lab.page.words.phrases import ASKS_FOR_TOKEN
from observer_lab.text import languages

WORD, PORT = "s3cret.Word_of~this-test", 8080
ACCESS = AccessToken(WORD, PORT)
RECEPTION = AdmissionControl(AccessPolicy.of("127.0.0.1", False), ACCESS, lambda refusal: None, dict, lambda visitor: "",
                             token_required_page("zh"))
WAYS: dict[str, Callable[[str], tuple[str, list[tuple[str, str]]]]] = {
    "address": lambda word: (f"/?token={word}", []),
    "address among others": lambda word: (f"/index.html?darkMode=1&token={word}", []),
    "cookie": lambda word: ("/", [("Cookie", f"other=1; observer-lab-{PORT}={word}")]),
    "header": lambda word: ("/", [("Authorization", f"Bearer {word}")]),
}
WRONG = ["", WORD[:-1], WORD + "x", WORD.upper(), f"x{WORD}", "é" * 8, "\xff", WORD.replace("s", "%73", 1)]


def asked(path: str, fields: list[tuple[str, str]], upgrade: bool = False, host: str = "127.0.0.1:8080") -> Response | None:
    """What is answered to a request; None where it gets its WebSocket."""
    head = [("Host", host), *fields, *([("Upgrade", "websocket")] if upgrade else [])]
    return RECEPTION.answer(Request(path, Headers(head)), PackedPage.of("<html>"), True)


@each("way", list(WAYS))
def test_the_word_lets_in_and_a_page_that_was_opened_by_it_is_kept_in(way: str) -> None:
    path, fields = WAYS[way](WORD)
    page = asked(path, fields)
    assert page is not None and asked(path, fields, upgrade=True) is None
    kept = page.headers.get("Set-Cookie")
    assert page.status_code == (200 if kept is None else 303)
    assert kept == (f"observer-lab-{PORT}={WORD}; HttpOnly; SameSite=Strict" if way.startswith("address") else None)
    if kept is not None:
        assert asked("/", [("Cookie", kept.partition(";")[0])], upgrade=True) is None


@each(("path", "left"), [("/?token={}", "./"), ("/index.html?token={}", "index.html"),
                         ("/?darkMode=1&token={}&a=%23", "./?darkMode=1&a=%23"),
                         ("/?%74oken={}", "./"), ("/?token={}&token=x", "./"), ("/?token={}&\udce9", "./")])
def test_a_word_in_the_address_is_exchanged_for_the_cookie_and_leaves_the_address(path: str, left: str) -> None:
    """The place is relative: a proxy may have taken away the path under which it shows the lab."""
    answer = asked(path.format(WORD), [])
    assert answer is not None and answer.status_code == 303 and answer.headers["Location"] == left
    assert WORD not in left and WORD not in f"{answer.body!r}" and answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["Set-Cookie"].startswith(f"observer-lab-{PORT}={WORD};")


def test_every_answer_gives_nothing_away_and_stands_in_no_frame() -> None:
    answers = [asked("/", []), asked("/", [("Cookie", f"observer-lab-{PORT}={WORD}")]), asked(f"/?token={WORD}", []),
               asked("/none", [("Authorization", f"Bearer {WORD}")]), asked("/health", [("Authorization", f"Bearer {WORD}")]),
               asked("/", [], host="evil.example"), asked("/", [], True)]
    for answer in answers:
        assert answer is not None
        assert answer.headers["X-Content-Type-Options"] == "nosniff" and answer.headers["Referrer-Policy"] == "no-referrer"
        assert answer.headers["X-Frame-Options"] == "DENY"
        if "html" in answer.headers["Content-Type"]:
            assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]


def test_a_site_that_is_named_may_show_the_page_and_the_cookie_goes_with_it_over_tls() -> None:
    open_to = replace(RECEPTION, headers=PageHeaders(("lms.example",)))
    page = PackedPage.of("<html>")
    known = Headers([("Host", "127.0.0.1:8080"), ("Cookie", f"observer-lab-{PORT}={WORD}")])
    shown = open_to.answer(Request("/", known), page, True)
    assert shown is not None and "X-Frame-Options" not in shown.headers
    assert shown.headers["Content-Security-Policy"].endswith("frame-ancestors https://lms.example")
    exchanged = open_to.answer(Request(f"/?token={WORD}", Headers([("Host", "127.0.0.1:8080")])), page, True)
    assert exchanged is not None and exchanged.headers["Set-Cookie"].endswith("; HttpOnly; SameSite=None; Secure; Partitioned")


@each(("said", "packed"), [("gzip", True), ("deflate, gzip;q=1.0", True), ("GZIP", True), ("gzip;q=0", False), ("gzip; q=0.000", False),
                           ("*;q=0", False), ("gzip;q=0.5, *;q=0", True), ("identity", False), ("x-gzip", True), ("notgzip", False)])
def test_the_page_is_packed_for_whoever_takes_it(said: str, packed: bool) -> None:
    page = asked("/", [("Authorization", f"Bearer {WORD}"), ("Accept-Encoding", said)])
    assert page is not None and ("Content-Encoding" in page.headers) == packed


@each(("peer", "said", "counted"), [("127.0.0.1", ["203.0.113.5"], "203.0.113.5"), ("::1", ["1.2.3.4, 203.0.113.5"], "203.0.113.5"),
                                    ("127.0.0.1", ["1.2.3.4", "2001:DB8::1"], "2001:db8::1"), ("127.0.0.1", [], "127.0.0.1"),
                                    ("127.0.0.1", ["unknown"], "127.0.0.1"), ("198.51.100.7", ["203.0.113.5"], "198.51.100.7"),
                                    ("10.1.2.3", ["203.0.113.5"], "203.0.113.5"),
                                    ("10.1.2.3", ["1.2.3.4, 203.0.113.5, 10.0.0.9"], "203.0.113.5"),
                                    ("::ffff:10.1.2.3", ["203.0.113.5"], "203.0.113.5"), ("10.1.2.3", ["10.9.9.9"], "10.9.9.9"),
                                    ("11.1.2.3", ["203.0.113.5"], "11.1.2.3"), ("127.0.0.1", ["203.0.113.5, unknown"], "127.0.0.1"),
                                    ("fd00::5", ["203.0.113.5"], "203.0.113.5"), ("fe80::5", ["203.0.113.5"], "fe80::5")])
def test_only_a_trusted_proxy_may_say_where_a_request_comes_from(peer: str, said: list[str], counted: str) -> None:
    proxies = TrustedProxies.of(["10.0.0.0/8", "fd00::/8"])
    assert proxies.sender(peer, Headers([("X-Forwarded-For", value) for value in said])) == counted
    own = ip_address(peer).is_loopback
    assert own or TrustedProxies().sender(peer, Headers([("X-Forwarded-For", value) for value in said])) == str(
        getattr(ip_address(peer), "ipv4_mapped", None) or ip_address(peer))


@given(st.ip_addresses(v=6), st.ip_addresses(v=6))
def test_addresses_of_ipv6_count_together_where_their_first_half_is_the_same(one: IPv6Address, other: IPv6Address) -> None:
    near = IPv6Address(int(one) >> 64 << 64 | int(other) & (1 << 64) - 1)
    if not any(each.is_loopback or each.ipv4_mapped for each in (one, other, near)):
        assert counted_address(str(one)) == counted_address(str(near))
        assert (counted_address(str(one)) == counted_address(str(other))) == (int(one) >> 64 == int(other) >> 64)


@each(("said", "secure"), [((), False), (("http",), False), (("https",), True), (("HTTPS, http",), True), (("http, https",), False),
                           (("https", "http"), False)])
def test_the_cookie_stays_on_tls_where_a_proxy_says_that_it_was_asked_so(said: tuple[str, ...], secure: bool) -> None:
    page = asked(f"/?token={WORD}", [("X-Forwarded-Proto", value) for value in said])
    assert page is not None and page.headers["Set-Cookie"].endswith("; Secure") == secure


@each(("way", "wrong"), [(way, wrong) for way in WAYS for wrong in WRONG if (way, wrong) != ("address", WRONG[-1])
                         and (way, wrong) != ("address among others", WRONG[-1])])
def test_another_word_is_turned_away_everywhere_with_a_sentence_in_every_language(way: str, wrong: str) -> None:
    path, fields = WAYS[way](wrong)
    for where in (path, path.replace("/", "/health", 1)):
        page, socket_ = asked(where, fields), asked(where, fields, upgrade=True)
        assert page is not None and socket_ is not None and page.status_code == socket_.status_code == HTTPStatus.UNAUTHORIZED
        told = page.body.decode("utf-8")
        assert all(ASKS_FOR_TOKEN(code) in told for code in languages()) and "Set-Cookie" not in page.headers
        assert WORD not in f"{told}{page.headers}{socket_.body!r}{socket_.headers}"


def test_a_foreign_name_is_refused_to_whoever_a_page_could_be_and_open_to_a_proxy_that_vouches() -> None:
    for way, ask in WAYS.items():
        path, fields = ask(WORD)
        for upgrade in (False, True):
            answer = asked(path, fields, upgrade, "hub.example")
            assert (answer is None or answer.status_code == 200) if way == "header" else answer is not None and answer.status_code == 403
        strange = asked(path, [*fields, ("Origin", "http://evil.example")], True)
        assert strange is not None and strange.status_code == 403, "the pages of others are refused whoever brings them"


def test_no_text_of_the_record_holds_the_word_and_words_are_long_enough() -> None:
    assert WORD not in repr(ACCESS) + str(RECEPTION)
    assert ACCESS.at("http://[::1]:8080") == f"http://[::1]:8080/?token={WORD}"
    assert len({draw_token() for _ in range(100)}) == 100 and all(len(draw_token()) >= TOKEN_BYTES for _ in range(9))
    for bad in ("", "short", "x" * 201, "a b c d e", "semi;colon", "new\nline-x", "ünïcödé-wörd"):
        with pytest.raises(ValueError, match="8 to 200"):
            AccessToken(bad, PORT)


@given(st.lists(st.tuples(st.integers(0, 2), st.booleans()), max_size=60), st.integers(1, 5))
def test_several_together_hold_no_more_tabs_than_there_are_places(moves: list[tuple[int, bool]], most: int) -> None:
    tally = SharedCounters(3, most)
    held: list[list[Place]] = [[], [], []]
    seats = [WorkerSlot(tally, worker) for worker in range(3)]
    for k, (worker, comes) in enumerate(moves):
        if comes:
            free, visitor = sum(map(len, held)) < most, Visitor(f"address {k}")
            assert seats[worker].full(visitor) != free
            place = seats[worker].enter(visitor)
            assert (place is not None) == free
            held[worker] += [] if place is None else [place]
        elif held[worker]:
            seats[worker].leave(held[worker].pop())
        assert [tally.of(k).tabs for k in range(3)] == list(map(len, held)) and tally.tabs == sum(map(len, held)) <= most
    tally.stand(1, False)  # its process has died
    assert tally.tabs == len(held[0]) + len(held[2]) and tally.places.kept == len(held[1])
    health = seats[0].health()
    assert isinstance(health["workers"], list) and health["tabs"] == sum(worker["tabs"] for worker in health["workers"])


def test_a_connection_is_handed_over_whole_and_its_end_is_heard_once() -> None:
    ours, theirs = socket.socketpair()
    over: list[int] = []
    with socket.create_server(("127.0.0.1", 0)) as door, ours, HandedListener(theirs, ("127.0.0.1", 1), lambda: over.append(1),
                                                                               lambda: None) as listener:
        with pytest.raises(BlockingIOError):
            listener.accept()
        with socket.create_connection(door.getsockname()) as browser:
            connection, address = door.accept()
            assert send_connection(ours, connection)
            connection.close()
            taken, peer = listener.accept()
            assert (
                isinstance(taken, HandedSocket) and peer == address == browser.getsockname() and listener.getsockname() == ("127.0.0.1", 1)
            )
            browser.sendall(b"?")
            assert taken.recv(9) == b"?" and not over
            taken.close()
            taken.close()
            assert over == [1] and browser.recv(9) == b""


def test_kernels_are_compiled_by_one_of_all_who_want_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled: list[int] = []

    def compile_beside() -> None:
        compiled.append(1)
        (tmp_path / compile_cache.DONE).touch()
    monkeypatch.delenv(compile_cache.KERNELS_VARIABLE, raising=False)
    monkeypatch.setattr(compile_cache, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(compile_cache, "_compile_beside", compile_beside)
    monkeypatch.setattr(compile_cache.CompileCache, "fill", lambda shelf: True)
    threads = [threading.Thread(target=compile_cache._prepare) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert compiled == [1]


CREW = """
import os, signal, socket, threading, time
from observer_lab.cli.workers import WorkerPool
from observer_lab.page.access.socket_handoff import READY
from observer_lab.page.access.shared_counters import SharedCounters

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored
tally, kind = SharedCounters(2), {kind!r}

def work(number, channel):
    first = number == 0 and tally.of(number).starts == 1
    channel.send(READY)
    while True:
        tally.note(number, int(first and kind == "stuck"))
        if not (first and kind == "silent"):
            tally.beat(number)
        time.sleep(0.02)

def end():
    while not (tally.of(0).starts > 1 and tally.of(0).stands):
        time.sleep(0.02)
    print(tally.of(0).starts, tally.of(1).starts, tally.of(0).stuck, flush=True)
    os.kill(os.getpid(), signal.SIGINT)

threading.Thread(target=end, daemon=True).start()
try:
    WorkerPool(socket.create_server(("127.0.0.1", 0)), tally, work, stuck=0.5, silent=60.0 if kind == "stuck" else 0.5,
         check=0.05).run(lambda: None)
except KeyboardInterrupt:
    pass
"""


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["stuck", "silent"])
def test_a_worker_that_is_stuck_or_silent_is_started_anew_and_the_other_goes_on(kind: str) -> None:
    ended = subprocess.run([sys.executable, "-c", CREW.format(kind=kind)], capture_output=True, text=True, timeout=120,
                           cwd=Path(__file__).parents[1])
    assert ended.returncode == 0, ended.stderr[-2000:]
    started, other, stuck = map(int, ended.stdout.split())
    assert started > 1 and stuck == 0
    assert other == 1 or kind == "silent"  # on a busy machine it beats late, too
