"""Find the public key by which a platform signed, and ask for its key set anew when it has changed.

A platform that does not answer holds up nobody else: each address is asked by one thread of its own, which holds no lock, at most once in
ten seconds. Launches wait for it on the loop for a bounded time. What was known before serves on meanwhile, for a day.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Any

import jwt

from .fetching import BAD_GATEWAY, TIMEOUT_S, LtiRefused, fetch_json
from .keys import ALGORITHM
from .settings import Platform

KEPT_S = 3600.0  # s for which a key set is not asked for again
STALE_S = 24 * 3600.0  # s for which it serves where the platform does not answer
ASK_AGAIN_S = 10.0  # s after which we ask again, for an unknown key or after a failure: a flood of launches must not flood the platform
WAIT_S = TIMEOUT_S + 1.0  # s that a launch waits for a platform
UNKNOWN_KEY = "The launch is signed by a key that the platform does not show."
SILENT = "The learning platform does not show its keys; try again later."


class KeysWantedError(Exception):
    """The key set of a platform has to be asked for first."""

    def __init__(self, platform: Platform) -> None:
        super().__init__(platform)
        self.platform = platform


@dataclass(frozen=True)
class _KeySet:
    """The keys by their ids, when they came, and when they were last asked for; `failed` where that brought none."""

    keys: Mapping[str, Any] = field(default_factory=dict)
    came: float = -STALE_S
    asked: float = -STALE_S
    failed: bool = False


class KeySets:
    """The key sets of all platforms, each kept for a while."""

    def __init__(self, fetch: Callable[[str], dict[str, Any]] = fetch_json, clock: Callable[[], float] = time.monotonic,
                 wait: float = WAIT_S) -> None:
        self._fetch, self._clock, self._wait = fetch, clock, wait
        self._kept: dict[str, _KeySet] = {}
        self._asking: dict[str, Future[None]] = {}
        self._lock = threading.Lock()  # never held while a platform is asked

    def key(self, platform: Platform, kid: object) -> Any:
        """The public key of that id. Raises LtiRefused, or KeysWantedError where `ask` may bring it."""
        if not isinstance(kid, str):
            raise LtiRefused(UNKNOWN_KEY)
        if platform.keys is not None:
            found = _public_keys(platform.keys).get(kid)
            if found is None:
                raise LtiRefused(UNKNOWN_KEY)
            return found
        with self._lock:
            known, now = self._kept.get(platform.key_set, _KeySet()), self._clock()
        found = known.keys.get(kid)
        if found is not None and now - known.came <= KEPT_S:
            return found
        if now - known.asked > ASK_AGAIN_S:
            raise KeysWantedError(platform)
        if found is None or now - known.came > STALE_S:
            raise LtiRefused(SILENT, BAD_GATEWAY) if known.failed else LtiRefused(UNKNOWN_KEY)
        return found

    async def ask(self, platform: Platform) -> None:
        """Wait until the platform's key set is known anew, or it is known that it does not come."""
        url = platform.key_set
        with self._lock:
            asking = self._asking.get(url)
            if asking is None:
                asking = self._asking[url] = Future()
                threading.Thread(target=self._ask, args=(url, asking), name="lti-keys", daemon=True).start()
        await asyncio.wait({asyncio.wrap_future(asking)}, timeout=self._wait)
        if not asking.done():
            self._failed(url)

    def _ask(self, url: str, asking: Future[None]) -> None:
        try:
            keys = _public_keys(self._fetch(url))
        except Exception:
            self._failed(url)
        else:
            with self._lock:
                self._kept[url] = _KeySet(keys, self._clock(), self._clock())
        with self._lock:
            del self._asking[url]
        asking.set_result(None)

    def _failed(self, url: str) -> None:
        with self._lock:
            self._kept[url] = replace(self._kept.get(url, _KeySet()), asked=self._clock(), failed=True)


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
