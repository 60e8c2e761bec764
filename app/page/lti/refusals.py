"""Say in one sentence why a launch is refused."""

from __future__ import annotations

from ..access.access_policy import Refusal


class LtiRefused(Exception):
    """A launch, or an answer of a platform, that is not accepted; one sentence says why."""

    def __init__(self, words: str, status: int = 403) -> None:
        super().__init__(words)
        self.refusal = Refusal(status, words)
