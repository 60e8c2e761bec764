"""The server that the soak mistreats, in a process of its own: `python tests/benchmarks/ward.py PORT FOLDER` serves until it is killed.

Its opening lesson misbehaves at some values of a knob (tests/wire/sick.py), and none of its files may grow beyond FILES, as on a full
disk.
"""

# ruff: noqa: E402 — the folders of the app and of the protocol client must be found first

from __future__ import annotations

import ctypes
import gc
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
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from websockets.asyncio.client import connect
from websockets.typing import Subprotocol

HERE = Path(__file__).parents[2]
sys.path[:0] = [str(HERE), str(HERE / "tests"), str(HERE / "tests" / "wire")]

from client import PATIENCE, WirePage  # type: ignore[import-not-found]
from sick import Sick  # type: ignore[import-not-found]

FILES = 2_000  # bytes that a file of the server may hold
REMEMBERED = 4096  # formulas that a server keeps drawn, the largest of its stores
HOARD = 300_000  # bytes in a thousandth of a second
ASLEEP, BLOCKED = 12.0, 45.0  # s after which a step that waits is given up, and that it waits for


def serve(port: int, folder: str) -> None:
    """Serve the sick lesson until killed. A number on stdin sets the clock so many seconds ahead; an empty line asks for the blocks of
    memory in use, after a collection, and gives back to the system what is not."""
    from observer_lab.cli.logs import set_up
    from observer_lab.lessons import LESSONS
    from observer_lab.page.screen.server import LabServer
    from observer_lab.session.session import WATCHDOG

    resource.setrlimit(resource.RLIMIT_FSIZE, (FILES, FILES))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a full disk is an error, not an end
    set_up(True, folder)
    WATCHDOG.asleep = ASLEEP
    fill_caches()
    server = LabServer({**LESSONS, "separation": Sick(HOARD, BLOCKED).lesson}, port=port, lesson="separation", max_sessions=60)
    print(server.url, flush=True)
    real = time.time
    for line in sys.stdin:
        if line.strip():
            time.time = lambda ahead=float(line): real() + ahead  # type: ignore[assignment]
            continue
        gc.collect()
        ctypes.CDLL(None).malloc_trim(0)
        print(sys.getallocatedblocks(), flush=True)


def fill_caches() -> None:
    """Draw as many exams as the server remembers: else these bounded stores, which a thousand tabs fill, would look like a leak."""
    from observer_lab.course.exercises.derivation import fill_placeholders
    from observer_lab.lessons import LESSONS
    from observer_lab.page.words.prose import render_markdown
    from observer_lab.text import joined, same

    lesson = LESSONS["separation"]
    for seed in range(REMEMBERED // len(lesson.exams)):
        for exam in lesson.exams:
            item = exam.item(str(seed))
            render_markdown(
                joined(same(fill_placeholders(lesson.words["en"].exams[exam.id].statement, item.given)), exam.digits.asked)("en")
            )


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

    def sample(self) -> tuple[float, float, float, float]:
        """Threads, sessions, megabytes, thousands of blocks of memory in use."""
        assert self.process.stdout is not None
        self._write("\n")
        blocks = float(self.process.stdout.readline()) / 1000
        return self._status("Threads"), float(self.health()["tabs"]), self.megabytes(), blocks

    def megabytes(self) -> float:
        """Memory that it holds now."""
        return self._status("VmRSS") / 1024

    def _status(self, name: str) -> float:
        return float(re.findall(rf"{name}:\s+(\d+)", Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii"))[0])

    def stop(self) -> None:
        """Kill it."""
        self.process.kill()
        self.process.wait()

    def set_clock(self, ahead: float) -> None:
        """Let the server's clock of the day be so many seconds ahead."""
        self._write(f"{ahead}\n")

    def _write(self, line: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(line)
        self.process.stdin.flush()


class Letter(WirePage):  # type: ignore[misc]
    """A page that keeps its last message."""

    words: bytes | str = b""

    def send_raw(self, data: bytes | str) -> None:
        self.words = data


async def connected(url: str, looks: bool) -> Any:
    """A connection that nobody reads from yet; one that `looks` is taken for a tab."""
    connection = await connect(f"ws://{urlsplit(url).netloc}", subprotocols=[Subprotocol(f"viser-v{version('viser')}")], compression=None,
                               max_size=None, open_timeout=PATIENCE)
    if looks:
        page = Letter()
        page.look()
        await connection.send(page.words)
    return connection


if __name__ == "__main__":
    serve(int(sys.argv[1]), sys.argv[2])
