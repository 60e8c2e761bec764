"""What the walks through a lab's surroundings share: their checks, free ports, and a window in which a lab is opened."""

from __future__ import annotations

import os
import socket
from pathlib import Path

from playwright.sync_api import Browser, Page

HERE = Path(__file__).parents[2]
KNOB = "stiffness error in the model [%]"
PATIENCE = 120.0  # s


class Walk:
    """The checks so far: one line each."""

    def __init__(self) -> None:
        self.failed = 0

    def check(self, words: str, holds: object, seen: object = "") -> None:
        """Print whether something holds, and what was seen where it does not."""
        self.failed += not holds
        print(f"{'ok    ' if holds else 'FAILED'} {words}" + ("" if holds else f": {str(seen)[:300]}"), flush=True)


def free_ports(count: int) -> list[int]:
    """Ports that nobody listens on now."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def window(browser: Browser, **options: bool) -> Page:
    """A window that shares nothing with others."""
    return browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce", **options).new_page()


def surroundings() -> dict[str, str]:
    """What a server that is asked to make a token of its own finds in its environment."""
    return {**os.environ, "PYTHONPATH": str(HERE), "OBSERVER_LAB_TOKEN": "auto", "OBSERVER_LAB_KERNELS": "off"}
