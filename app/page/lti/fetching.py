"""Ask a platform for keys and access tokens, and give it points, bounded in time and size; or refuse."""

from __future__ import annotations

import http.client
import json
import time
import urllib.error
import urllib.request
from collections.abc import Mapping
from typing import Any
from urllib.parse import urlencode

from ..access.access_policy import Refusal

TIMEOUT_S = 5.0  # s for an answer of a platform
MAX_ANSWER_BYTES = 256 * 1024  # bytes of an answer that are read
BAD_GATEWAY = 502


class LtiRefused(Exception):
    """A launch, or an answer of a platform, that is not accepted; one sentence says why."""

    def __init__(self, words: str, status: int = 403) -> None:
        super().__init__(words)
        self.refusal = Refusal(status, words)


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """A platform's address is the operator's choice; it does not send us elsewhere."""

    def redirect_request(self, req: Any, fp: Any, code: int, msg: str, headers: Any, newurl: str) -> None:
        """Nowhere."""


def fetch_json(url: str) -> dict[str, Any]:
    """The JSON object at an address. Raises LtiRefused."""
    return _object(_opened(urllib.request.Request(url, headers={"Accept": "application/json"})))


def post_form(url: str, fields: Mapping[str, str]) -> dict[str, Any]:
    """The JSON object by which an address answers a form. Raises LtiRefused."""
    return _object(_opened(urllib.request.Request(url, urlencode(fields).encode(), {"Accept": "application/json"})))


def post_json(url: str, content: Mapping[str, object], kind: str, bearer: str) -> None:
    """Post JSON of a kind with an access token. Raises LtiRefused."""
    _opened(urllib.request.Request(url, json.dumps(content).encode(), {"Content-Type": kind, "Authorization": f"Bearer {bearer}"}))


def _opened(request: urllib.request.Request) -> bytes:
    try:
        with urllib.request.build_opener(_NoRedirect).open(request, timeout=TIMEOUT_S) as answer:
            return _read(answer)
    except urllib.error.HTTPError as problem:
        problem.close()
        raise LtiRefused(f"The learning platform answered {problem.code}; try again later.", BAD_GATEWAY) from problem
    except (OSError, http.client.HTTPException, ValueError) as problem:
        raise LtiRefused("The learning platform does not answer; try again later.", BAD_GATEWAY) from problem


def _read(answer: http.client.HTTPResponse) -> bytes:
    """What is read of an answer, in bounded time also where it comes byte by byte."""
    end, parts, size = time.monotonic() + TIMEOUT_S, list[bytes](), 0
    while size <= MAX_ANSWER_BYTES and (part := answer.read1(MAX_ANSWER_BYTES)):
        parts.append(part)
        size += len(part)
        if time.monotonic() > end:
            raise TimeoutError
    return b"".join(parts)


def _object(answer: bytes) -> dict[str, Any]:
    try:
        data = json.loads(answer) if len(answer) <= MAX_ANSWER_BYTES else None
    except (ValueError, RecursionError):
        data = None
    if not isinstance(data, dict):
        raise LtiRefused("The learning platform's answer is not the JSON that it should be.", BAD_GATEWAY)
    return data
