"""Open the doors for learning platforms: read the file of `--lti`, and say what is missing."""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from .opening import Opening, ServeRequest
from .options import CommandError

if TYPE_CHECKING:
    from ..page.lti.doors import LtiDoors
    from ..page.lti.settings import LtiSettings

NEEDED = ("jwt", "cryptography")
NOT_INSTALLED = '--lti needs more packages; run pip install "observer-lab[lti]".'
NO_ROOM = "Give --lti without --room: a platform opens lessons, and a room has its own links."
MAKE_KEY = "draw one with `openssl genrsa -out FILE 3072`"


@dataclass(frozen=True)
class OpenPlatforms:
    """The settings."""

    settings: LtiSettings

    @property
    def address(self) -> str:
        """The lab's address as platforms know it."""
        return self.settings.address

    def doors(self, first: Opening, request: ServeRequest, port: int) -> LtiDoors:
        """The doors of a server on a port. Raises CommandError."""
        from ..page.lti.doors import LtiDoors
        from ..page.lti.keys import ToolKeys
        from .courses import now

        assert first.ledger is not None
        try:
            keys = ToolKeys(self.settings.private_key)
        except ValueError as problem:
            raise CommandError(f"The key file of {str(request.lti)[:80]} cannot be used: {problem}; {MAKE_KEY}.") from problem
        return LtiDoors(self.settings, keys, first.ledger, first.lessons, first.course, port, now, request.language, request.mode)


def open_platforms(request: ServeRequest) -> OpenPlatforms | None:
    """The platforms of the file that `--lti` names, None without one. Raises CommandError."""
    if request.lti is None:
        return None
    if request.room:
        raise CommandError(NO_ROOM)
    if any(find_spec(name) is None for name in NEEDED):
        raise CommandError(NOT_INSTALLED)
    from ..page.lti.settings import LtiFileError, read_settings
    from .courses import warn_if_open
    from .inputs import read_text

    beside = Path(request.lti).parent

    def read_key(name: str) -> str:
        warn_if_open(beside / name)
        return read_text(str(beside / name), "key", MAKE_KEY)

    try:
        settings = read_settings(read_text(request.lti, "platforms", "give the file of your platforms; README.md shows one"),
                                 read_key)
    except LtiFileError as problem:
        raise CommandError(f"The file of platforms {request.lti[:80]} cannot be used: {problem}.") from problem
    return OpenPlatforms(settings)


def token_for_launches(request: ServeRequest) -> str | None:
    """The access token: one is drawn where none is given, so that nobody comes in but by a launch or by the address that is printed."""
    from ..page.access.tokens import VARIABLE

    return "auto" if request.token is None and not os.environ.get(VARIABLE) else request.token
