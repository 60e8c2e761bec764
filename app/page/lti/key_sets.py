"""Find the public key by which a platform signed, and ask for its key set anew when it has changed."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import jwt

from .fetching import fetch_json
from .keys import ALGORITHM
from .refusals import LtiRefused
from .settings import Platform

KEPT_S = 3600.0  # s for which a key set is not asked for again
ASK_AGAIN_S = 10.0  # s after which an unknown key makes us ask again: a flood of launches must not flood the platform
UNKNOWN_KEY = "The launch is signed by a key that the platform does not show."


@dataclass(frozen=True)
class _KeySet:
    keys: Mapping[str, Any]
    asked: float


class KeySets:
    """The key sets of all platforms, each kept for a while."""

    def __init__(self, fetch: Callable[[str], dict[str, Any]] = fetch_json, clock: Callable[[], float] = time.monotonic) -> None:
        self._fetch, self._clock = fetch, clock
        self._kept: dict[str, _KeySet] = {}
        self._lock = threading.Lock()

    def key(self, platform: Platform, kid: object) -> Any:
        """The public key of that id. Raises LtiRefused."""
        if not isinstance(kid, str):
            raise LtiRefused(UNKNOWN_KEY)
        if platform.keys is not None:
            found = _public_keys(platform.keys).get(kid)
        else:
            found = self._keys(platform.key_set, KEPT_S).get(kid) or self._keys(platform.key_set, ASK_AGAIN_S).get(kid)
        if found is None:
            raise LtiRefused(UNKNOWN_KEY)
        return found

    def _keys(self, url: str, kept: float) -> Mapping[str, Any]:
        with self._lock:
            known = self._kept.get(url)
            if known is None or self._clock() - known.asked > kept:
                known = self._kept[url] = _KeySet(_public_keys(self._fetch(url)), self._clock())
            return known.keys


def _public_keys(data: Mapping[str, Any]) -> dict[str, Any]:
    """The RSA keys of a key set by their ids; others are passed over."""
    found = {}
    for entry in data["keys"] if isinstance(data.get("keys"), list) else ():
        if isinstance(entry, dict) and entry.get("kty") == "RSA" and "d" not in entry and isinstance(kid := entry.get("kid"), str):
            try:
                found[kid] = jwt.PyJWK(entry, algorithm=ALGORITHM)
            except jwt.PyJWTError:
                continue
    return found
