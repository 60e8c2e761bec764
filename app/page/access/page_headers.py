"""Write the header fields of every answer: no sniffing, no referrer, no foreign frame."""

from __future__ import annotations

from dataclasses import dataclass

from websockets.http11 import Response

from .access_policy import content_policy


@dataclass(frozen=True)
class PageHeaders:
    """Fields of every answer; `frames` are the sites that may show the page inside theirs, none by default."""

    frames: tuple[str, ...] = ()

    def complete(self, answer: Response, host: str) -> None:
        """Add the fields to an answer to a request for `host`."""
        headers = answer.headers
        headers["X-Content-Type-Options"] = "nosniff"
        headers["Referrer-Policy"] = "no-referrer"
        if not self.frames:
            headers["X-Frame-Options"] = "DENY"
        if headers.get("Content-Type", "").startswith("text/html") and "Content-Security-Policy" not in headers:
            headers["Content-Security-Policy"] = content_policy(host, self.frames)
