"""The doors of the server: those that all tabs share are closed, strangers are refused before a word is read."""

from __future__ import annotations

import http.client
import socket
from collections.abc import Callable
from urllib.error import HTTPError
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest
import viser
from client import WireTab, empty
from websockets.exceptions import InvalidStatus

from observer_lab.lessons import LESSONS
from observer_lab.page.access.handshake import MAX_MESSAGE_BYTES, RETRY_AFTER_S, UPLOAD_PART_BYTES
from observer_lab.page.screen.server import LabServer
from observer_lab.page.viser_private import viser_internals
from observer_lab.page.words.phrases import FULL
from observer_lab.session.session import Session

STIFFNESS = "stiffness error in the model [%]"
Enter = Callable[..., WireTab]
Newest = Callable[[], Session]
SHARED = {"GuiUpdateMessage", "GuiButtonHoldMessage", "GuiFormSubmitMessage", "GuiFormDirtyMessage", "FileTransferStartUpload",
          "FileTransferPart", "CommandTriggerMessage", "TransformControlsUpdateMessage", "TransformControlsDragStartMessage",
          "TransformControlsDragEndMessage", "SceneNodeClickMessage", "SceneNodeDragMessage", "ScenePointerMessage",
          "ShareUrlDisconnect", "ShareUrlRequest"}
OWN = {"ViewerCameraMessage", "GuiUpdateMessage", "CommandTriggerMessage", "SceneNodeDragMessage", "SceneNodeClickMessage",
       "FileTransferStartUpload", "FileTransferPart"}
NEEDLESS = SHARED - OWN - {"ShareUrlDisconnect", "ShareUrlRequest"}


def answer(server: LabServer, path: str = "/", *hosts: str, method: str = "GET", **fields: str) -> http.client.HTTPResponse:
    """The answer to a plain request with just these fields."""
    place = urlsplit(server.url)
    connection = http.client.HTTPConnection(place.hostname or "", place.port, timeout=10)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for host in hosts or (place.netloc,):
        connection.putheader("Host", host)
    for name, value in fields.items():
        connection.putheader(name.replace("_", "-"), value)
    connection.endheaders()
    return connection.getresponse()


def test_the_handlers_of_viser_are_those_we_know() -> None:
    """An upgrade of viser that opens a new door fails here: look at it before it is let in."""
    closed: list[frozenset[str]] = []
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        server._websock_server.on_client_connect(lambda connection: closed.append(viser_internals.keep_own_doors(connection)))
        assert {message.__name__ for message in server._websock_server._incoming_handlers} == SHARED
        with WireTab(f"http://127.0.0.1:{server.get_port()}") as tab:
            tab.until(lambda: closed, "the connection")
        assert closed == [NEEDLESS]
    finally:
        server.stop()


def test_nothing_that_a_tab_says_reaches_or_outlives_others(enter: Enter, server: LabServer) -> None:
    """A rebroadcast was kept for every later visitor: memory for a hostile page to fill."""
    a, b = enter(), enter()
    kept = server._server._websock_server.get_message_buffer().message_counter
    for i in range(200):
        a.send("GuiFormDirtyMessage", uuid=f"form {i}" + "x" * 1000)
        a.send("GuiFormSubmitMessage", uuid=f"form {i}")
    a.update(STIFFNESS, value=3.0)  # handled after all that came before
    a.until(lambda: any(s.picture.design["stiffness_error"] == 3.0 for s in server.sessions.values()))  # type: ignore[union-attr]
    assert server._server._websock_server.get_message_buffer().message_counter == kept
    assert b.unasked() == []


@pytest.mark.parametrize("origin", ["http://evil.example", "https://evil.example:8080", "http://127.0.0.1:1", "null"])
def test_a_page_of_another_site_is_refused_at_the_handshake(server: LabServer, origin: str) -> None:
    with pytest.raises(InvalidStatus) as refused:
        WireTab(server.url, origin=origin)
    assert refused.value.response.status_code == 403
    assert not server.sessions


def test_a_connection_under_a_name_that_was_made_to_point_here_is_refused(server: LabServer) -> None:
    for hosts in (("evil.example:80",), ("127.0.0.1", "evil.example")):
        with pytest.raises(InvalidStatus) as refused:
            WireTab(server.url, hosts=hosts)
        assert refused.value.response.status_code in (400, 403)


def test_the_page_is_refused_under_a_foreign_name_and_says_why(server: LabServer) -> None:
    refused = answer(server, "/", "evil.example")
    assert refused.status == 403 and b"--allow-host evil.example" in refused.read()
    assert refused.headers["Content-Type"].startswith("text/plain")
    assert answer(server, "/", "127.0.0.1", "evil.example").status == 400
    assert answer(server, "/", "127.0.0.1", "127.0.0.1").status == 400


def test_the_page_may_call_nobody_but_the_server_it_came_from(server: LabServer) -> None:
    """viser's page connects to whatever stands behind ?websocket= in its address, and runs the scripts it is sent."""
    page = answer(server, "/?websocket=ws%3A%2F%2Fevil.example")
    rules = dict(rule.split(" ", 1) for rule in page.headers["Content-Security-Policy"].split("; "))
    host = urlsplit(server.url).netloc
    assert set(rules["connect-src"].split()) == {"'self'", "data:", "blob:", f"ws://{host}", f"wss://{host}"}
    assert rules["default-src"] == rules["base-uri"] == rules["form-action"] == "'none'"


def test_the_page_comes_packed_or_plain_and_once(server: LabServer) -> None:
    plain, packed = answer(server), answer(server, Accept_Encoding="gzip, deflate")
    assert plain.headers["Content-Encoding"] is None and packed.headers["Content-Encoding"] == "gzip"
    assert int(plain.headers["Content-Length"]) == len(plain.read())
    assert answer(server, If_None_Match=plain.headers["ETag"]).status == 304
    assert answer(server, "/index.html").status == 200


@pytest.mark.parametrize("path", ["/etc/passwd", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//", "/index.html/", "/assets"])
def test_there_is_no_other_file(server: LabServer, path: str) -> None:
    assert answer(server, path).status == 404


def raw_answer(server: LabServer, data: bytes) -> bytes:
    """All that comes back for these bytes."""
    place = urlsplit(server.url)
    with socket.create_connection((place.hostname, place.port), timeout=10) as stranger:
        stranger.sendall(data)
        return b"".join(iter(lambda: stranger.recv(65536), b""))


def test_health_checks_of_proxies_are_answered(server: LabServer) -> None:
    """HEAD and GET, HTTP/1.1 and 1.0, with a Host and without one where that is allowed."""
    for path in ("/", "/health"):
        head, page = answer(server, path, method="HEAD"), answer(server, path)
        assert head.status == page.status == 200 and head.read() == b"" and page.read()
        assert head.headers["Content-Type"] == page.headers["Content-Type"]
        if path == "/":
            assert head.headers["Content-Length"] == page.headers["Content-Length"]
    host = urlsplit(server.url).netloc.encode()
    for request in (b"GET /health HTTP/1.0\r\n\r\n",
                    b"HEAD /health HTTP/1.0\r\n\r\n", b"GET /health HTTP/1.1\r\nHost: " + host + b"\r\n\r\n"):
        assert raw_answer(server, request).startswith(b"HTTP/1.1 200 OK\r\n")


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH"])
def test_other_methods_are_told_which_are_allowed(server: LabServer, method: str) -> None:
    refused = answer(server, "/health", method=method)
    assert refused.status == 405 and refused.headers["Allow"] == "GET, HEAD" and refused.read()


def test_a_head_that_is_too_large_or_none_is_told_so(server: LabServer) -> None:
    assert raw_answer(server, b"GET / HTTP/1.1\r\nCookie: " + b"x" * 9000 + b"\r\n\r\n").startswith(b"HTTP/1.1 431 ")
    assert raw_answer(server, b"hello there\r\n\r\n").startswith(b"HTTP/1.1 400 ")


def test_a_websocket_stands_at_the_path_of_the_page_alone(server: LabServer) -> None:
    for path in ("/health", "/anything", "/index.html/"):
        with pytest.raises(InvalidStatus) as refused:
            WireTab(server.url, path=path)
        assert refused.value.response.status_code == 404
    WireTab(server.url, path="/?s=1", camera=False).close()


def test_a_message_beyond_the_largest_ends_its_connection_alone(enter: Enter, server: LabServer) -> None:
    good = enter()
    bad = WireTab(server.url)
    bad.send_raw(bytes(MAX_MESSAGE_BYTES + 1))
    assert bad.closed() == 1009
    bad.close()
    good.update(STIFFNESS, value=4.0)
    good.until(lambda: any(s.picture and s.picture.design["stiffness_error"] == 4.0 for s in server.sessions.values()))


def test_a_part_of_an_upload_fits_into_the_largest_message(enter: Enter) -> None:
    tab = enter()
    tab.send("FileTransferPart", source_component_uuid="nobody", transfer_uuid="none", part_index=0, content=bytes(UPLOAD_PART_BYTES))
    tab.update(STIFFNESS, value=4.0)
    tab.until(lambda: tab.value(STIFFNESS) == 4.0, "an answer")


def test_noise_instead_of_http_is_survived(server: LabServer) -> None:
    place = urlsplit(server.url)
    for noise in (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", b"GET / HTTP/1.1\r\nX: " + b"y" * 20_000 + b"\r\n\r\n", b"\r\n"):
        with socket.create_connection((place.hostname, place.port), timeout=10) as stranger:
            stranger.sendall(noise)
    assert answer(server).status == 200


def test_a_full_server_says_so_and_goes_on_serving_those_inside() -> None:
    """Who comes is told in every language and asks again by itself; whoever has got through the door meanwhile is told too."""
    server = LabServer(LESSONS, port=0, max_sessions=1, language="zh")
    try:
        early = WireTab(server.url, camera=False)
        with WireTab(server.url) as first:
            first.until(lambda: len(server.sessions) == 1, "the first tab")
            with pytest.raises(InvalidStatus) as refused:
                WireTab(server.url)
            with pytest.raises(HTTPError) as turned_away:
                urlopen(server.url, timeout=10)
            assert refused.value.response.status_code == turned_away.value.code == 503
            assert refused.value.response.headers["Retry-After"] == turned_away.value.headers["Retry-After"] == str(RETRY_AFTER_S)
            told = turned_away.value.read().decode("utf-8")
            said = [FULL.format(places=1, seconds=RETRY_AFTER_S)(code) for code in ("zh", "en")]
            assert f'http-equiv="refresh" content="{RETRY_AFTER_S}"' in told and 0 < told.index(said[0]) < told.index(said[1])
            with urlopen(f"{server.url}/health", timeout=10) as health:
                assert health.status == 200
            early.look()
            early.until(lambda: any("full" in note for note in early.notes), "the sentence")
            early.close()
            assert len(server.sessions) == 1 and not early.widgets
        empty(server)
        with WireTab(server.url) as third:
            third.until(third.mark, "a place that has become free")
    finally:
        server.stop()
