"""Read the head of an HTTP request, so that every well-formed one gets an answer.

websockets reads GET of HTTP/1.1 alone and hangs up on the rest, which a proxy reports as a dead server. What it can answer is
rewritten here into that; what it cannot is refused with a status. A form is read at those paths alone that take one.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from websockets.datastructures import Headers
from websockets.exceptions import SecurityError
from websockets.http11 import Request
from websockets.streams import StreamReader

from .access_policy import Refusal

MAX_HEAD_BYTES = 32 * 1024  # bytes of the request line and all fields
MAX_FORM_BYTES = 64 * 1024  # bytes of a form
FORM_TYPE = b"application/x-www-form-urlencoded"
BODY_FIELDS = re.compile(rb"(?im)^(content-length|content-type|transfer-encoding|expect):[ \t]*([^\r\n]*?)[ \t]*(?:\r\n|\Z)")
METHODS = ("GET", "HEAD")
REQUEST_LINE = re.compile(rb"([!#$%&'*+.^_`|~0-9A-Za-z-]{1,40}) ([^ \r\n]+) HTTP/1\.([01])")
BEGINS = re.compile(rb"(?:\r\n)?[!#$%&'*+.^_`|~0-9A-Za-z-]{1,40}(?: |\Z)|\r?\n?\Z")
NOT_HTTP = Refusal(400, "This is not a request of HTTP/1.0 or HTTP/1.1.")
TOO_LARGE = Refusal(431, "The head of the request is too large.")
METHOD = Refusal(405, "Only GET and HEAD are answered here.")
BODY = Refusal(413, "A request may carry no body here.")
NO_LENGTH = Refusal(411, "A form must say its length once, in Content-Length.")
LONG_FORM = Refusal(413, f"A form may hold {MAX_FORM_BYTES // 1024} KB at most.")
NO_FORM = Refusal(415, f"Only a form is taken here, as {FORM_TYPE.decode()}.")


@dataclass(frozen=True)
class RequestStart:
    """A request that can be answered: its method, its fields, and its bytes as websockets reads them, with what came behind. `form` is
    its body."""

    method: str
    fields: Headers
    data: bytes
    form: bytes = b""


def read_head(received: bytes, here: str, forms: Collection[str] = ()) -> RequestStart | Refusal | None:
    """Decide by the bytes that a connection has sent so far; None while its head, or its form, is not complete.

    A form may be posted to the paths of `forms`. `here` is the address that the connection came to: the host of a request of HTTP/1.0
    that names none. A browser always names one.
    """
    if BEGINS.match(received) is None:
        return NOT_HTTP
    received = received.removeprefix(b"\r\n")  # a line feed behind an earlier request is allowed
    head, end, behind = received.partition(b"\r\n\r\n")
    if len(head) > MAX_HEAD_BYTES:
        return TOO_LARGE
    if not end:
        return None
    line, _, fields = head.partition(b"\r\n")
    found = REQUEST_LINE.fullmatch(line)
    if found is None:
        return TOO_LARGE if len(line) > MAX_HEAD_BYTES // 4 else NOT_HTTP
    method, path, minor = found[1].decode("ascii"), found[2], found[3]
    form = b""
    if method == "POST" and path.partition(b"?")[0].decode("latin-1") in forms:
        length = _form_length(fields)
        if isinstance(length, Refusal):
            return length
        if len(behind) < length:
            return None
        form, behind, fields = behind[:length], behind[length:], BODY_FIELDS.sub(b"", fields).removesuffix(b"\r\n")
    elif method not in METHODS:
        return METHOD
    rewritten = b"GET " + path + b" HTTP/1.1\r\n" + (fields + b"\r\n" if fields else b"")
    if minor == b"0" and re.search(rb"(?im)^host:", fields) is None:
        rewritten += b"Host: " + here.encode("ascii", "ignore") + b"\r\n"
    read = _read(rewritten + b"\r\n")
    return read if isinstance(read, Refusal) else RequestStart(method, read.headers, rewritten + b"\r\n" + behind, form)


def _form_length(fields: bytes) -> int | Refusal:
    """How many bytes of a form follow the head."""
    found = [(name.lower(), value) for name, value in BODY_FIELDS.findall(fields)]
    lengths = [value for name, value in found if name == b"content-length"]
    if len(lengths) != 1 or not lengths[0].isdigit() or any(name == b"transfer-encoding" for name, _ in found):
        return NO_LENGTH
    if len(lengths[0]) > len(str(MAX_FORM_BYTES)) or int(lengths[0]) > MAX_FORM_BYTES:
        return LONG_FORM
    kinds = [value.partition(b";")[0].strip().lower() for name, value in found if name == b"content-type"]
    return int(lengths[0]) if kinds == [FORM_TYPE] else NO_FORM


def _read(head: bytes) -> Request | Refusal:
    """The request as websockets reads this head, or why it would not."""
    reader = StreamReader()
    reader.feed_data(head)
    reading = Request.parse(reader.read_line)
    try:
        next(reading)
    except StopIteration as read:
        assert isinstance(read.value, Request)
        return read.value
    except SecurityError:
        return TOO_LARGE
    except (NotImplementedError, ValueError) as problem:
        return BODY if "body" in str(problem) or "transfer" in str(problem) else NOT_HTTP
    except Exception:
        return NOT_HTTP
    return NOT_HTTP
