"""Hold one page that many browsers show: each change is packed once for all of them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any

from viser import infra

from .adapter import LabGui, LabScene
from .message_transport import pack
from .viser_internals import fixed_camera

PASSING = frozenset({"play"})  # scripts of which somebody who comes later needs nothing
REPEATED = frozenset({"flat"})  # scripts that are called for one node after another


class SharedPage(infra.WebsockMessageHandler):
    """What `viser.ClientHandle` is for one browser, as far as a screen uses it, for all browsers that follow.

    `send` gets each batch packed. `standing()` is the whole page for a browser that comes later.
    """

    def __init__(self, width: int, height: int, send: Callable[[bytes], object]) -> None:
        super().__init__()
        self.client_id, self._send = 0, send
        self._websock_connection = self._viser_server = self
        self._scene_lifecycle_lock = threading.RLock()
        self._new: dict[str, Any] = {}  # messages since the last flush, by what replaces them
        self._standing: dict[str, Any] = {}
        owner: Any = self
        self.scene = LabScene(owner, None, None)  # nobody answers, so that no callback is ever called
        self.gui = LabGui(owner, None, None)
        self.camera = fixed_camera(owner, width, height)

    def get_message_buffer(self) -> Any:
        """Where viser puts a message."""
        return self

    @property
    def message_from_id(self) -> dict[str, Any]:
        """What waits to be sent, under the name that it has in viser's buffer."""
        return self._new

    def push(self, message: Any) -> None:
        """Keep a message until the next flush; a newer one takes the place of those that it makes idle."""
        script = script_name(message)
        key = message.redundancy_key() if script in ("", *PASSING) else f"script {message.source if script in REPEATED else script}"
        for kept in (self._new, self._standing):
            kept.pop(key, None)
        self._new[key] = message
        if message.lifecycle_phase == "remove":
            self._forget(message.entity_type, getattr(message, message.entity_id_field))
        elif script not in PASSING:
            self._standing[key] = message

    def _forget(self, kind: str, name: str) -> None:
        """Whoever comes later needs nothing of a widget or node that was removed, nor of the nodes below it."""
        below = name + "/" if kind == "scene" else "\0"
        for key, message in list(self._standing.items()):
            about = message.entity_state_key()
            if about == (kind, name) or str(getattr(message, "name", "")).startswith(below):
                del self._standing[key]

    def remove_entity_state_from_buffer(self, kind: str, name: str) -> None:
        """Another node takes the place of one with this name: nothing that was said of the old one is true of it."""
        for kept in (self._new, self._standing):
            for key in [key for key, message in kept.items() if message.entity_state_key() == (kind, name)]:
                del kept[key]

    @contextmanager
    def atomic(self) -> Generator[None, None, None]:
        """A batch ends with `flush` alone."""
        yield

    sanctioned_dead_writes = atomic  # nobody has left whom a message could be meant for

    def flush(self) -> None:
        """Send what has been put here since the last time."""
        messages, self._new = list(self._new.values()), {}
        if messages:
            self._send(pack(messages))

    def standing(self) -> bytes:
        """All that stands on the page, as one batch."""
        return pack(list(self._standing.values()))


def script_name(message: Any) -> str:
    """The name of the script of ours that a message runs, "" where it runs none."""
    source = getattr(message, "source", None)
    return source.partition("\n")[0].removeprefix("// ").removesuffix(".js") if isinstance(source, str) else ""
