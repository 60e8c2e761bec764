"""The server: one session with its own screen for every tab, and nothing shared between them."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping

import viser

from ..lesson.lesson import Lesson
from ..tab.commands import Refuse
from ..tab.session import Session
from . import phrases, quirks
from .address import is_public, listen, url
from .gate import Gate, Refusal
from .plants import MOST_BYTES
from .screen import Screen

log = logging.getLogger(__name__)

TOLD = 20  # different refusals that are written down: a name is enough to help, and a flood is none


class LabServer:
    """Observer Lab on a port: every tab that connects gets a session, every tab that leaves takes it away."""

    def __init__(self, lessons: Mapping[str, Lesson], host: str = "127.0.0.1", port: int = 8080,
                 lesson: str = "separation", language: str = "en", max_sessions: int = 200, plant: str = "",
                 names: Iterable[str] = ()) -> None:
        """Raises OSError where it cannot listen, ValueError at a name that is none."""
        self._lessons = lessons
        self._lesson, self._language, self._max, self._plant = lesson, language, max_sessions, plant
        self._sessions: dict[int, Session] = {}
        self._host, self._refused = host, set[Refusal]()
        gate = Gate.of(host, is_public(host), names)
        self._server = quirks.open_server(listen(host, port), gate, self._write_down)
        self._server.on_client_connect(self._enter)
        self._server.on_client_disconnect(self._leave)

    @property
    def url(self) -> str:
        """Where the page is: the port may differ from the one asked for, when that was taken."""
        return url(self._host, self._server.get_port())

    @property
    def sessions(self) -> Mapping[int, Session]:
        """The open tabs' sessions."""
        return self._sessions

    def _write_down(self, refusal: Refusal) -> None:
        if refusal not in self._refused and len(self._refused) < TOLD:
            self._refused.add(refusal)
            log.warning("refused: %s", refusal.words)

    async def _enter(self, client: viser.ClientHandle) -> None:
        if len(self._sessions) >= self._max:
            client.add_notification("Observer Lab", f"This server is full ({self._max} tabs). Close one and reload.",
                                    color="red")
            return
        screen = Screen(client)
        session = Session(self._lessons, screen, self._lesson, self._language, plant=self._plant)
        screen.attach(session.post)
        quirks.accept_values_only(client, lambda: session.post(Refuse(phrases.NONSENSE)))
        quirks.accept_small_files_only(client, MOST_BYTES, lambda: session.post(Refuse(phrases.TOO_LARGE)))
        self._sessions[client.client_id] = session
        session.start()

    async def _leave(self, client: viser.ClientHandle) -> None:
        session = self._sessions.pop(client.client_id, None)
        if session is not None:
            session.close()

    def wait(self) -> None:
        """Serve until interrupted."""
        self._server.sleep_forever()

    def stop(self) -> None:
        """Close every session and the server."""
        for session in list(self._sessions.values()):
            session.close()
        self._server.stop()
