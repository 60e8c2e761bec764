"""Every request gets an answer: what can be read is read, what cannot has a status; nothing is read without a bound."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.http11 import Request
from websockets.streams import StreamReader

from observer_lab.page.access.access_policy import Refusal
from observer_lab.page.access.request_head import MAX_HEAD_BYTES, RequestStart, read_head

HERE = "127.0.0.1:8080"


def request_of(data: bytes) -> Request:
    """What websockets makes of it."""
    reader = StreamReader()
    reader.feed_data(data)
    reading = Request.parse(reader.read_line)
    try:
        next(reading)
    except StopIteration as end:
        return end.value
    raise AssertionError("not complete")


@pytest.mark.parametrize("method", ["GET", "HEAD"])
@pytest.mark.parametrize("version", ["HTTP/1.0", "HTTP/1.1"])
@pytest.mark.parametrize("field", ["", "Host: lab.example\r\n", "host: lab.example\r\n"])
def test_get_and_head_of_both_versions_are_read(method: str, version: str, field: str) -> None:
    found = read_head(f"{method} /health?x=1 {version}\r\nA: b\r\n{field}\r\nrest".encode(), HERE)
    assert isinstance(found, RequestStart) and found.method == method and found.data.endswith(b"\r\n\r\nrest")
    request = request_of(found.data)
    assert request.path == "/health?x=1" and request.headers["A"] == "b"
    named = ["lab.example"] if field else [HERE] if version == "HTTP/1.0" else []
    assert request.headers.get_all("Host") == named


@pytest.mark.parametrize(("head", "status"), [
    (b"POST / HTTP/1.1\r\nHost: a\r\n\r\n", 405), (b"OPTIONS * HTTP/1.0\r\n\r\n", 405), (b"PUT / HTTP/1.1\r\n\r\n", 405),
    (b"GET / HTTP/2.0\r\n\r\n", 400), (b"GET /\r\n\r\n", 400), (b"\x16\x03\x01\x02\x00\x01", 400), (b"hello world\r\n\r\n", 400),
    (b"GET / HTTP/1.1\r\nno colon\r\n\r\n", 400), (b"GET / HTTP/1.1\r\n bad: 1\r\n\r\n", 400), (b"GET / HTTP/1.1\r\na: \x00\r\n\r\n", 400),
    (b"GET / HTTP/1.1\r\nContent-Length: 5\r\n\r\nhello", 413), (b"GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n", 413),
    (b"GET / HTTP/1.1\r\nCookie: " + b"x" * 9000 + b"\r\n\r\n", 431), (b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 200 + b"\r\n", 431),
    (b"GET /" + b"x" * 40_000, 431), (b"GET / HTTP/1.1\r\nA: " + b"y" * 40_000, 431),
], ids=lambda value: str(value)[:40] if isinstance(value, bytes) else str(value))
def test_what_cannot_be_answered_has_a_status(head: bytes, status: int) -> None:
    found = read_head(head, HERE)
    assert isinstance(found, Refusal) and found.status == status


def posted(*fields: bytes, path: bytes = b"/form", body: bytes = b"a=b") -> RequestStart | Refusal | None:
    """What becomes of a form."""
    return read_head(b"\r\n".join([b"POST " + path + b"?x=1 HTTP/1.1", b"Host: a", *fields, b"", body]), HERE, ("/form",))


FORM, LENGTH = b"Content-Type: application/x-www-form-urlencoded; charset=utf-8", b"content-length: 3"


def test_a_form_is_read_where_it_may_be_posted_and_nowhere_else() -> None:
    for fields in ((LENGTH, FORM), (FORM, LENGTH), (FORM, b"A: b", LENGTH, b"Cookie: c=d")):
        found = posted(*fields)
        assert isinstance(found, RequestStart) and (found.method, found.form) == ("POST", b"a=b")
        request = request_of(found.data)
        assert request.path == "/form?x=1" and request.headers["Host"] == "a" and "Content-Length" not in request.headers
    for path in (b"/", b"/form/", b"/Form", b"/%66orm"):
        refusal = posted(LENGTH, FORM, path=path)
        assert isinstance(refusal, Refusal) and refusal.status == 405
    assert posted(FORM, b"Content-Length: 65536") is None, "the rest is waited for"


@pytest.mark.parametrize(("fields", "status"), [
    ((FORM,), 411), ((FORM, LENGTH, LENGTH), 411), ((FORM, b"Content-Length: -3"), 411), ((FORM, b"Content-Length: 3, 3"), 411),
    ((FORM, LENGTH, b"Transfer-Encoding: chunked"), 411), ((FORM, b"Content-Length: 65537"), 413),
    ((FORM, b"Content-Length: " + b"9" * 40), 413), ((LENGTH,), 415), ((LENGTH, b"Content-Type: text/plain"), 415),
    ((LENGTH, FORM, FORM), 415), ((FORM, b" folded", LENGTH), 400)],
    ids=range(11))
def test_a_form_without_a_bound_or_of_another_kind_is_refused(fields: tuple[bytes, ...], status: int) -> None:
    found = posted(*fields)
    assert isinstance(found, Refusal) and found.status == status


@pytest.mark.parametrize("field", [b"Content-Length: 0", b"Accept-Encoding: gzip", b"X: \xe9"])
def test_harmless_fields_pass(field: bytes) -> None:
    assert isinstance(read_head(b"GET / HTTP/1.1\r\nHost: a\r\n" + field + b"\r\n\r\n", HERE), RequestStart)


@given(st.binary(max_size=300), st.integers(0, 300))
def test_noise_never_raises_and_is_never_kept_beyond_the_bound(noise: bytes, cut: int) -> None:
    for data in (noise, b"GET " + noise, b"GET / HTTP/1.1\r\n" + noise, (b"GET / HTTP/1.1\r\nHost: a\r\n\r\n" + noise)[:cut]):
        found = read_head(data, HERE)
        assert found is None or isinstance(found, Refusal | RequestStart)
        if isinstance(found, RequestStart):
            request_of(found.data)
        assert read_head(data + b"x" * (MAX_HEAD_BYTES + 1), HERE) is not None
