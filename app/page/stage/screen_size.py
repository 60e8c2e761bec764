"""Keep parts of the scene at a constant size on the screen for any camera and window."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

import viser

from ...session.commands.commands import Edit, RunOnTabThread


class ScreenSized(Protocol):
    """A part of the scene whose size depends on the camera."""

    def needs_resize(self, em: float) -> bool:
        """Whether `fit` has something to do; asked from the server's loop."""
        ...

    def fit(self, em: float) -> None:
        """Take the size that letters of `em` stage units, and the camera, ask for."""
        ...


def follow_camera(client: viser.ClientHandle, post: Callable[[Edit], int], heard: Callable[[], object], em: Callable[[], float],
           parts: Callable[[], Iterable[ScreenSized]]) -> None:
    """Have the parts fitted, on the tab's own thread, when the browser tells of a camera that they do not fit; each calls `heard`."""
    waits = False

    def fit() -> None:
        nonlocal waits
        waits, size = False, em()
        for part in parts():
            part.fit(size)
        client.flush()

    @client.camera.on_update
    async def _(_: viser.CameraHandle) -> None:
        nonlocal waits
        heard()
        if not waits and any(part.needs_resize(em()) for part in parts()):
            waits = True
            post(RunOnTabThread(fit))
