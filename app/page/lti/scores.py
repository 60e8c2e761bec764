"""Send points to a platform.

Source: IMS Global, "Assignment and Grade Services 2.0", section 3.4, and "Security Framework 1.0", section 4.1.
"""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from urllib.parse import urlsplit, urlunsplit

from .fetching import BAD_GATEWAY, LtiRefused, post_form, post_json
from .keys import ToolKeys
from .launch import SCORE_SCOPE
from .settings import Platform

SCORE_TYPE = "application/vnd.ims.lis.v1.score+json"
ASSERTION_TYPE = "urn:ietf:params:oauth:client-assertion-type:jwt-bearer"
ASSERTION_S = 300  # s for which a request for an access token holds
MARGIN_S = 60.0  # s before its end at which an access token is not used any more
MAX_TOKEN_S = 3600.0  # s for which one is kept at most
PAUSES_S = (1.0, 4.0)  # s between two tries


class Scores:
    """Access tokens of all platforms, each kept while it holds. `clock` gives seconds since 1970, `wait` waits between two tries."""

    def __init__(self, keys: ToolKeys, clock: Callable[[], float], wait: Callable[[float], object] = time.sleep) -> None:
        self._keys, self._clock, self._wait = keys, clock, wait
        self._tokens: dict[tuple[str, str], tuple[str, float]] = {}
        self._lock = threading.Lock()

    def send(self, platform: Platform, lineitem: str, user: str, given: float, most: float, at: int) -> None:
        """Tell the platform how many points of `most` a person has at a time (ms since 1970). Raises LtiRefused after the last try.

        A platform keeps the points of the latest time, so that a try that comes late takes nothing back.
        """
        score = {"timestamp": datetime.fromtimestamp(at / 1000, UTC).isoformat(timespec="milliseconds"), "scoreGiven": given,
                 "scoreMaximum": most, "activityProgress": "Submitted", "gradingProgress": "FullyGraded", "userId": user}
        for pause in (*PAUSES_S, None):
            try:
                post_json(score_address(lineitem), score, SCORE_TYPE, self._token(platform))
                return
            except LtiRefused:
                self._forget(platform)
                if pause is None:
                    raise
                self._wait(pause)

    def _token(self, platform: Platform) -> str:
        name = (platform.issuer, platform.client_id)
        with self._lock:
            token, end = self._tokens.get(name, ("", 0.0))
        if token and time.monotonic() < end:
            return token
        now = int(self._clock())
        claims = {"iss": platform.client_id, "sub": platform.client_id, "aud": platform.audience, "iat": now, "exp": now + ASSERTION_S,
                  "jti": secrets.token_urlsafe(16)}
        answer = post_form(platform.token, {"grant_type": "client_credentials", "client_assertion_type": ASSERTION_TYPE,
                                            "client_assertion": self._keys.sign(claims), "scope": SCORE_SCOPE})
        match answer:
            case {"access_token": str(token)} if token.isascii() and token.isprintable():
                seconds = answer.get("expires_in")
                lasts = min(float(seconds), MAX_TOKEN_S) if isinstance(seconds, (int, float)) else MAX_TOKEN_S
                with self._lock:
                    self._tokens[name] = token, time.monotonic() + lasts - MARGIN_S
                return token
        raise LtiRefused("The learning platform gave no access token.", BAD_GATEWAY)

    def _forget(self, platform: Platform) -> None:
        with self._lock:
            self._tokens.pop((platform.issuer, platform.client_id), None)


def score_address(lineitem: str) -> str:
    """Where the points of a line item go: its address with /scores at the end of the path."""
    parts = urlsplit(lineitem)
    return urlunsplit((parts.scheme, parts.netloc, f"{parts.path.rstrip('/')}/scores", parts.query, ""))
