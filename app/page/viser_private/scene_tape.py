"""Record a scene that no browser looks at."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any

from viser import infra

from .adapter import CleanRecorder, LabScene

MOVES = MappingProxyType({"SetPositionMessage": "position", "SetOrientationMessage": "wxyz", "SetSceneNodeVisibilityMessage": "visible"})


class Tape(infra.WebsockMessageHandler):
    """Where a scene is put that no browser looks at: `viser.ClientHandle` as far as the stage and its boards use one.

    viser makes its recording of all that is put there but for what happens in `changes`.
    """

    def __init__(self, camera: Any) -> None:
        super().__init__()
        self.client_id, self.camera = 0, camera
        self._websock_connection = self._viser_server = self
        self._scene_lifecycle_lock = threading.RLock()
        self._sent: list[Any] | None = None  # while changes are watched
        self._recorder = CleanRecorder(self, lambda message: message.include_in_scene_serialization and self._sent is None)
        self._record_handles.append(self._recorder)
        self.scene = LabScene(self, None, None)  # nobody looks, so no callback is ever called

    def get_message_buffer(self) -> Any:
        """Where viser puts a message."""
        return self

    def push(self, message: infra.Message) -> None:
        """Keep a message while changes are watched."""
        if self._sent is not None:
            self._sent.append(message)

    @contextmanager
    def atomic(self) -> Generator[None, None, None]:
        """Nobody looks, so nothing is seen half done."""
        yield

    def changes(self, step: Callable[[], object]) -> Iterator[tuple[str, str, Any]]:
        """What a step changes: the name of the node, the property and its value."""
        self._sent = sent = []
        step()
        self._sent = None
        for message in sent:
            kind, name = type(message).__name__, message.name
            changed = {MOVES[kind]: getattr(message, MOVES[kind])} if kind in MOVES else message.updates
            yield from ((name, prop, value) for prop, value in changed.items())

    def recording(self) -> bytes:
        """viser's recording, with the scripts that were run; once."""
        return self._recorder.serialize()
