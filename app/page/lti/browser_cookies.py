"""Keep a login and a launch in the browser that made them, sealed, as cookies that work in a frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import urlsplit

from ..access.access_policy import RequestHead
from .keys import ToolKeys

LOGIN_S, LAUNCH_S = 600, 12 * 3600  # s for which a login waits for its launch, and a launch for hand-ins
MAX_LOGINS, MAX_LAUNCHES = 4, 6  # of a browser: websockets reads 8 KB of cookies
FLAGS = "HttpOnly; SameSite=None; Secure; Partitioned"


class SealedCookies:
    """The cookies of one lab at an address. Those of the servers of one machine differ by port."""

    def __init__(self, keys: ToolKeys, address: str, port: int) -> None:
        self._keys, self._name = keys, f"observer-lab-{port}"
        path = urlsplit(address).path
        self.path = path[:path.rfind("/") + 1] or "/"

    def login(self, head: RequestHead, state: str, content: Mapping[str, Any]) -> list[str]:
        """The fields Set-Cookie that keep a login under its state."""
        return self._keep(head, f"{self._name}-login-", _short(state), content, LOGIN_S, MAX_LOGINS)

    def launch(self, head: RequestHead, id: str, content: Mapping[str, Any]) -> list[str]:
        """The fields Set-Cookie that keep a launch under its id."""
        return self._keep(head, f"{self._name}-launch-", id, content, LAUNCH_S, MAX_LAUNCHES)

    def login_of(self, head: RequestHead, state: str) -> dict[str, Any] | None:
        """The login that a browser made with this state, None where it made none."""
        return self._opened(head, f"{self._name}-login-{_short(state)}", LOGIN_S)

    def launch_of(self, head: RequestHead, id: str) -> dict[str, Any] | None:
        """The launch that a browser made under this id."""
        return self._opened(head, f"{self._name}-launch-{id}", LAUNCH_S)

    def without_login(self, state: str) -> str:
        """The field Set-Cookie that ends a login."""
        return self._field(f"{self._name}-login-{_short(state)}", "", 0)

    def _keep(self, head: RequestHead, prefix: str, id: str, content: Mapping[str, Any], seconds: int, most: int) -> list[str]:
        """The new cookie, and the end of the oldest of its kind where there are too many."""
        others = sorted(((self._keys.sealed_at(word), name) for name, word in _cookies(head) if name.startswith(prefix)), reverse=True)
        old = [name for _, name in others if name != prefix + id][most - 1:]
        return [self._field(prefix + id, self._keys.seal(content), seconds), *(self._field(name, "", 0) for name in old)]

    def _opened(self, head: RequestHead, name: str, seconds: int) -> dict[str, Any] | None:
        return next((self._keys.opened(word, seconds) for given, word in _cookies(head) if given == name), None)

    def _field(self, name: str, word: str, seconds: int) -> str:
        return f"{name}={word}; Max-Age={seconds}; Path={self.path}; {FLAGS}"


def _short(state: str) -> str:
    """The part of a state that names its cookie, of characters that a name may have."""
    return "".join(sign for sign in state[:12] if sign.isascii() and (sign.isalnum() or sign in "-_"))


def _cookies(head: RequestHead) -> Iterator[tuple[str, str]]:
    for value in head.get_all("Cookie"):
        for part in value.split(";"):
            name, _, word = part.strip().partition("=")
            yield name, word
