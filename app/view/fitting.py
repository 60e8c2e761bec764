"""What stays as large on the screen whatever camera and window do: what a hand takes hold of, and words."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

import viser

from ..tab.commands import Edit, Tend


class Fitted(Protocol):
    """A part of the scene whose size depends on the camera."""

    def misfits(self, em: float) -> bool:
        """Whether `fit` has something to do; asked from the server's loop."""
        ...

    def fit(self, em: float) -> None:
        """Take the size that letters of `em` stage units, and the camera, ask for."""
        ...


def follow(client: viser.ClientHandle, post: Callable[[Edit], int], heard: Callable[[], object], em: Callable[[], float],
           parts: Callable[[], Iterable[Fitted]]) -> None:
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
        if not waits and any(part.misfits(em()) for part in parts()):
            waits = True
            post(Tend(fit))
