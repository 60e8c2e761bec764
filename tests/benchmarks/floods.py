"""What each kind of flood costs the others: `python tests/benchmarks/floods.py [--seconds 15] [--only pings]` prints a table.

The server is a process of its own (`observer_lab serve`). One honest tab moves a slider five times a second and waits for each answer;
meanwhile a flood of one kind runs from this process for some seconds, and comes back whenever it is dropped. The table says, for each
kind: the 95th percentile of the honest tab's waits in ms, the most memory that the server held beyond what it held before in MB,
the time until the first connection of the flood was dropped in s (— where none was), and the lines that the log took.

The script runs on any version of the lab, so that a table before and after a change can be made.
"""

# ruff: noqa: E402 — the folders of the app and of the protocol client must be found first

from __future__ import annotations

import argparse
import asyncio
import contextlib
import os
import re
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable
from importlib.metadata import version
from pathlib import Path
from urllib.parse import urlsplit

import msgspec
from websockets.frames import Frame, Opcode

HERE = Path(__file__).parents[2]
sys.path[:0] = [str(HERE), str(HERE / "tests"), str(HERE / "tests" / "wire"), str(HERE / "tests" / "benchmarks")]

from bench_many import enter, share  # type: ignore[import-not-found]

DELAY = "input delay [ms]"
CHUNK = 64 * 1024  # bytes that a flood sends at once
PAUSE_S = 0.05  # s between two chunks: about 1.3 MB/s, what one telephone can send
SILENT = 300  # connections that say nothing
SENDER = "198.51.100.1"  # the address that floods, as a proxy would say
GREETING = ("GET / HTTP/1.1\r\nHost: {host}\r\nX-Forwarded-For: {sender}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            f"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Protocol: viser-v{version('viser')}\r\n\r\n")


def chunk(opcode: Opcode, payload: bytes, fin: bool = True) -> bytes:
    """As many masked frames as fit."""
    one = Frame(opcode, payload, fin).serialize(mask=True)
    return one * max(1, CHUNK // len(one))


COMMAND = msgspec.msgpack.encode({"type": "CommandTriggerMessage", "uuid": "nobody"})
FIRST_PIECE = Frame(Opcode.BINARY, b"", False).serialize(mask=True)
FLOODS: dict[str, tuple[bytes, bytes]] = {  # what is sent once, and again and again
    "pings, never read": (b"", chunk(Opcode.PING, b"x" * 125)),
    "empty pieces": (FIRST_PIECE, chunk(Opcode.CONT, b"", False)),
    "commands before the camera": (b"", chunk(Opcode.BINARY, COMMAND)),
    "text": (b"", chunk(Opcode.TEXT, b"text")),
    "messages that cannot be read": (b"", chunk(Opcode.BINARY, b"\xc1")),
}


class Served:
    """The server's process, and what the system says of it."""

    def __init__(self, folder: str) -> None:
        self.log = Path(folder) / "stderr"
        with self.log.open("wb") as told:
            self.process = subprocess.Popen([sys.executable, "-m", package(), "serve", "--port", "0", "--lesson", "separation",
                                             "--view", "lab"],
                                            cwd=HERE,
                                            stdout=subprocess.PIPE, stderr=told, text=True,
                                            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "OBSERVER_LAB_KERNELS": "off"})
        assert self.process.stdout is not None
        self.url = next(found[0] for line in self.process.stdout if (found := re.search(r"http://[\d.]+:\d+", line)))

    def megabytes(self) -> float:
        """Memory that it holds now."""
        status = Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii")
        return float(re.findall(r"VmRSS:\s+(\d+)", status)[0]) / 1024

    def lines(self) -> int:
        """Lines of its log."""
        return self.log.read_bytes().count(b"\n")

    def stop(self) -> None:
        """Kill it."""
        self.process.kill()
        self.process.wait()


def package() -> str:
    """The import name of the lab, which older versions called otherwise."""
    import importlib.util

    return "observer_lab" if importlib.util.find_spec("observer_lab") else "app"


async def flood_once(url: str, first: bytes, again: bytes, end: float, sender: str) -> float | None:
    """Send until `end` on the clock of the loop, as an address `sender` behind a proxy; s until dropped, None where it was not."""
    began, place = time.monotonic(), urlsplit(url)
    plain = socket.socket()
    plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    plain.setblocking(False)
    loop = asyncio.get_running_loop()
    with plain:
        try:
            await loop.sock_connect(plain, (place.hostname, place.port))
            await loop.sock_sendall(plain, GREETING.format(host=place.netloc, sender=sender).encode() + first)
            while (left := end - time.monotonic()) > 0:
                await asyncio.wait_for(loop.sock_sendall(plain, again), max(0.1, left))
                await asyncio.sleep(PAUSE_S)
        except TimeoutError:
            return None
        except OSError:
            return time.monotonic() - began
    return None


async def flood(url: str, first: bytes, again: bytes, end: float) -> float | None:
    """Send from one connection after another; s until the first was dropped."""
    dropped: float | None = None
    while time.monotonic() < end:
        took = await flood_once(url, first, again, end, SENDER)
        dropped = took if dropped is None else dropped
        await asyncio.sleep(0.2)
    return dropped


async def silent(url: str, words: bytes, end: float) -> float | None:
    """Open many connections, say `words` and nothing more; s until the first was closed by the server."""
    began, opened, place, loop = time.monotonic(), [], urlsplit(url), asyncio.get_running_loop()
    for _ in range(SILENT):
        with contextlib.suppress(OSError, TimeoutError):
            plain = socket.socket()
            plain.setblocking(False)  # the honest tab lives in this process, too: nothing may wait for the flood
            opened.append(plain)
            await asyncio.wait_for(loop.sock_connect(plain, (place.hostname, place.port)), 5)
            await loop.sock_sendall(plain, words)
    dropped: float | None = None
    while time.monotonic() < end:
        await asyncio.sleep(0.2)
        if dropped is None and any(_ended(plain) for plain in opened):
            dropped = time.monotonic() - began
    for plain in opened:
        plain.close()
    return dropped


def _ended(plain: socket.socket) -> bool:
    plain.setblocking(False)
    try:
        while said := plain.recv(65536):
            assert said
        return True
    except BlockingIOError:
        return False
    except OSError:
        return True


async def row(name: str, act: Callable[[str, float], Awaitable[float | None]], seconds: float) -> str:
    """One line of the table, on a server of its own."""
    with tempfile.TemporaryDirectory() as folder:
        served = Served(folder)
        try:
            listeners: list[asyncio.Task[None]] = []
            tab, _ = await enter(served.url, False, listeners)
            await tab.answered(rests=True)
            before = most = served.megabytes()
            lines, waits, value = served.lines(), [], 0.0
            task = asyncio.create_task(_begun(act(served.url, time.monotonic() + seconds)))
            while not task.done():
                value, began = (value + 6.0) % 48.0, time.monotonic()
                tab.send("GuiUpdateMessage", uuid=tab.find(DELAY), updates={"value": value})
                await tab.answered()
                waits.append(1e3 * (time.monotonic() - began))
                most = max(most, served.megabytes())
                await asyncio.sleep(0.2)
            dropped = await task
            told = "—" if dropped is None else f"{dropped:.1f}"
            return f"| {name} | {share(waits, 0.95):.0f} | {most - before:.0f} | {told} | {served.lines() - lines} |"
        finally:
            served.stop()


async def _begun(act: Awaitable[float | None]) -> float | None:
    return await act


async def _nothing(_: str, end: float) -> float | None:
    await asyncio.sleep(max(0.0, end - time.monotonic()))
    return None


async def table(seconds: float, only: str) -> None:
    """Print the rows whose names begin with `only`."""
    print("| flood | honest tab's p95 [ms] | memory [MB] | dropped after [s] | lines of log |\n|---|---|---|---|---|", flush=True)
    rows: dict[str, Callable[[str, float], Awaitable[float | None]]] = {"none": _nothing}
    for name, (first, again) in FLOODS.items():
        rows[name] = lambda url, end, a=first, b=again: flood(url, a, b, end)
    for name, words in ((f"{SILENT} connections, silent", ""), (f"{SILENT} WebSockets without a tab", GREETING)):
        rows[name] = lambda url, end, said=words: silent(url, said.format(host=urlsplit(url).netloc, sender=SENDER).encode(), end)
    for name, act in rows.items():
        if name.startswith(only):
            print(await row(name, act, seconds), flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seconds", type=float, default=15.0)
    parser.add_argument("--only", default="", help="rows whose name begins so")
    asked = parser.parse_args()
    asyncio.run(table(asked.seconds, asked.only))
