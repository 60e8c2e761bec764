"""The server that the soak mistreats, in a process of its own: `python tests/benchmarks/ward.py PORT FOLDER` serves until it is killed.

Its opening lesson misbehaves at some values of a knob (tests/wire/sick.py), and none of its files may grow beyond FILES, as on a full
disk.
"""

# ruff: noqa: E402 — the folders of the app and of the protocol client must be found first

from __future__ import annotations

import json
import os
import re
import resource
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path
from typing import Any

HERE = Path(__file__).parents[2]
sys.path[:0] = [str(HERE), str(HERE / "tests" / "wire")]

from sick import Sick  # type: ignore[import-not-found]

FILES = 2_000  # bytes that a file of the server may hold
HOARD = 300_000  # bytes in a thousandth of a second
ASLEEP, BLOCKED = 12.0, 45.0  # s after which a step that waits is given up, and that it waits for


def serve(port: int, folder: str) -> None:
    """Serve the sick lesson until killed; a line on stdin sets the clock an hour ahead, or back."""
    from app.cli.logs import set_up
    from app.tab.session import WATCH
    from app.view.server import LabServer
    from lessons import LESSONS

    resource.setrlimit(resource.RLIMIT_FSIZE, (FILES, FILES))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a full disk is an error, not an end
    set_up(True, folder)
    WATCH.asleep = ASLEEP
    server = LabServer({**LESSONS, "separation": Sick(HOARD, BLOCKED).lesson}, port=port, lesson="separation", max_sessions=60)
    print(server.url, flush=True)
    real = time.time
    for line in sys.stdin:
        ahead = float(line)
        time.time = lambda shift=ahead: real() + shift  # type: ignore[assignment]


class Ward:
    """The server's process and what the operating system says of it."""

    def __init__(self, folder: str, port: int = 0) -> None:
        self.process = subprocess.Popen([sys.executable, str(Path(__file__)), str(port), folder], cwd=HERE, text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        env={**os.environ, "PYTHONPATH": str(HERE), "OBSERVER_LAB_KERNELS": "off"})
        self.said: list[str] = []  # lines on stderr
        assert self.process.stdout is not None and self.process.stderr is not None
        threading.Thread(target=self.said.extend, args=(self.process.stderr,), daemon=True).start()
        self.url = self.process.stdout.readline().strip()
        assert self.url, "the server did not start"

    def health(self) -> dict[str, Any]:
        """What GET /health says."""
        with urllib.request.urlopen(self.url + "/health", timeout=30) as answer:
            return json.loads(answer.read())

    def sample(self) -> tuple[float, float, float]:
        """Threads, sessions, megabytes."""
        status = Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii")
        threads, held = (float(re.findall(rf"{name}:\s+(\d+)", status)[0]) for name in ("Threads", "VmRSS"))
        return threads, float(self.health()["tabs"]), held / 1024

    def stop(self) -> None:
        """Kill it."""
        self.process.kill()
        self.process.wait()

    def set_clock(self, ahead: float) -> None:
        """Let the server's clock of the day be so many seconds ahead."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{ahead}\n")
        self.process.stdin.flush()


if __name__ == "__main__":
    serve(int(sys.argv[1]), sys.argv[2])
