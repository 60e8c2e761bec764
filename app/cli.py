"""The command line."""

from __future__ import annotations

from app.view.server import LabServer
from lessons import LESSONS, OPENING


def main() -> int:
    server = LabServer(LESSONS, port=8080, lesson=OPENING)
    print(server.url, flush=True)
    server.wait()
    return 0
