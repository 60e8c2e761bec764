"""Describe the parts that a server may have: a lecture room, and doors for learning platforms."""

from __future__ import annotations

from asyncio import AbstractEventLoop
from typing import Any, Protocol

import viser

from ...classroom.room import VoteDesk
from ...course.handin.learner import Learner
from ...session.session import Session
from ..access.access_policy import RequestHead
from ..access.connection import Connection
from ..access.handshake import Doors


class Room(VoteDesk, Protocol):
    """A lecture room, as far as the server uses it. Its presenter's screens are of a kind of their own, hence `Any`."""

    @property
    def state(self) -> str:
        """The token of what the lecture showed last."""
        ...

    @property
    def failing(self) -> bool:
        """Whether the room's store cannot be read or written."""
        ...

    def start(self, loop: AbstractEventLoop) -> None:
        """Begin, with followers on this loop."""

    def close(self) -> None:
        """End."""

    def presenter_screen(self, client: viser.ClientHandle) -> Any:
        """The screen of a tab that presents."""

    def own_screen(self, client: viser.ClientHandle) -> Any:
        """The screen of a tab that works on its own."""

    def present(self, client_id: int, session: Session, screen: Any) -> None:
        """A tab presents."""

    def work_alone(self, client_id: int, session: Session) -> None:
        """A tab works on its own."""

    def follow(self, client: viser.ClientHandle, connection: Connection) -> None:
        """A tab follows."""

    def leave(self, client_id: int) -> bool:
        """A tab has left; whether it followed."""
        ...


class LaunchDoors(Doors, Protocol):
    """The doors for learning platforms, which know whom they sent."""

    def asked(self, path: str) -> bool:
        """Whether a tab says that it was launched."""
        ...

    def learner(self, path: str, head: RequestHead) -> Learner | None:
        """Whom a tab belongs to."""
        ...
