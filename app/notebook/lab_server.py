"""Serve lessons to one notebook from within its kernel, on a free port of this machine."""

from __future__ import annotations

import atexit
import re
from functools import lru_cache
from urllib.parse import urlsplit

from observer_lab.lessons import all_lessons

from ..page.access.addresses import listen
from ..page.access.tokens import AccessToken, draw_token
from ..page.screen.server import LabServer

ORIGIN = re.compile(r"https?://(?:[\w.-]{1,253}|\[[0-9A-Fa-f:]{2,45}\])(?::\d{1,5})?", re.ASCII)
LOOPBACK = ("localhost", "127.0.0.1")
MAX_TABS = 20


class NotebookServer:
    """A lab that the pages of one origin may show in a frame, and nobody else; its word is asked for as well."""

    def __init__(self, origin: str) -> None:
        listener = listen("127.0.0.1", 0)
        self._port = listener.getsockname()[1]
        self._access = AccessToken(draw_token(), self._port)
        name = urlsplit(origin).hostname
        self._host = name if name in LOOPBACK else LOOPBACK[1]  # the same name is the same site, whatever the port
        self._server = LabServer(all_lessons(), listener=listener, access=self._access, frames=(origin,), max_sessions=MAX_TABS)
        atexit.register(self._server.stop)

    @property
    def address(self) -> str:
        """Where it is, with its word."""
        return self._access.at(f"http://{self._host}:{self._port}")


@lru_cache(maxsize=8)
def server_for(origin: str) -> NotebookServer:
    """The server of the notebooks of an origin; it ends with the kernel. Raises ValueError at what is no origin."""
    if ORIGIN.fullmatch(origin) is None:
        raise ValueError(f"{origin[:60]!r} is not the origin of a notebook, as http://localhost:8888 is.")
    return NotebookServer(origin)
