"""Check the access token of a server: in the address once, then in a cookie or a header."""

from __future__ import annotations

import hmac
import re
import secrets
from collections.abc import Iterator
from dataclasses import dataclass
from dataclasses import field as record_field
from urllib.parse import parse_qs, quote, unquote_plus

from .access_policy import RequestHead

VARIABLE = "OBSERVER_LAB_TOKEN"  # of the environment, which the list of processes does not show
FIELD = "token"  # of an address
PRESENTER_FIELD = "present"  # of the presenter's link
SHAPE = re.compile(r"[A-Za-z0-9._~-]{8,200}", re.ASCII)
TOKEN_BYTES = 24  # of a word that is drawn


def draw_token() -> str:
    """A token that nobody can guess."""
    return secrets.token_urlsafe(TOKEN_BYTES)


@dataclass(frozen=True)
class AccessToken:
    """What one must know of the server on a port. The word stands in no text of this record."""

    word: str = record_field(repr=False)
    port: int
    field: str = FIELD  # of an address

    def __post_init__(self) -> None:
        """Raises ValueError at a word that an address cannot hold, or that is soon guessed."""
        if SHAPE.fullmatch(self.word) is None:
            raise ValueError("an access token is 8 to 200 letters, digits, dots, dashes, underscores or tildes")

    def has_token_header(self, head: RequestHead) -> bool:
        """Whether a header holds the word: no page can put it there, so a program sent it, as a proxy that asks who comes does."""
        return self._knows(value[7:].strip() for value in head.get_all("Authorization") if value[:7].lower() == "bearer ")

    def shown(self, path: str) -> bool:
        """Whether the address holds the word."""
        return self._knows(parse_qs(path.partition("?")[2]).get(self.field, []))

    def knows_token(self, head: RequestHead, path: str) -> bool:
        """Whether whoever sends this knows the word."""
        return self.has_token_header(head) or self.shown(path) or self._knows(self._cookies(head))

    def cookie(self, head: RequestHead) -> str:
        """The field Set-Cookie by which a browser keeps the word. It names no path: a browser takes the one that it asked for,
        which a proxy may have shortened on its way to us. Where a proxy says that it was asked over TLS, it stays on TLS."""
        asked = [value.split(",")[0].strip().lower() for value in head.get_all("X-Forwarded-Proto")]
        return f"{self._name}={self.word}; HttpOnly; SameSite=Strict" + ("; Secure" if asked == ["https"] else "")

    def cookie_in_frames(self) -> str:
        """The field Set-Cookie for a page inside those of other sites: over TLS alone, and kept apart for each of them."""
        return f"{self._name}={self.word}; HttpOnly; SameSite=None; Secure; Partitioned"

    def address_without(self, path: str) -> str:
        """The address of a request without the word, relative to it: a proxy may have taken away where the page stands."""
        place, _, question = path.partition("?")
        rest = [part for part in question.split("&") if part.isascii() and part and unquote_plus(part.partition("=")[0]) != self.field]
        return (place.rpartition("/")[2] or "./") + ("?" + "&".join(rest) if rest else "")

    def at(self, url: str) -> str:
        """An address with the word in it."""
        return f"{url.rstrip('/')}/?{self.field}={quote(self.word)}"

    @property
    def _name(self) -> str:
        part = "" if self.field == FIELD else f"-{self.field}"
        return f"observer-lab-{self.port}{part}"  # the servers of one machine share the cookies of its name

    def _cookies(self, head: RequestHead) -> Iterator[str]:
        for value in head.get_all("Cookie"):
            for part in value.split(";"):
                name, _, word = part.strip().partition("=")
                if name == self._name:
                    yield word

    def _knows(self, words: Iterator[str] | list[str]) -> bool:
        ours = self.word.encode()
        return any([hmac.compare_digest(word.encode("utf-8", "surrogateescape"), ours) for word in words])
