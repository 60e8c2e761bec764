"""A lecture with many followers: how soon each sees the presenter's knob, and how soon all votes are acknowledged.

    python tests/benchmarks/bench_room.py [--followers 100] [--moves 40] [--workers 2]

The server is a process of its own with its workers, on loopback; presenter and followers are protocol clients in this one. A
move counts for a follower when the batch arrives whose card shows its value or a later one. All followers of one kind get the
same bytes, so each batch is read once. The price is the processor's time of the server's processes for each follower and move.
"""

# ruff: noqa: E402 — the folders of the app and of the protocol client must be found first

from __future__ import annotations

import argparse
import asyncio
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

HERE = Path(__file__).parents[2]
sys.path[:0] = [str(HERE), str(HERE / "tests" / "wire")]

from client import PATIENCE, WirePage, unpack  # type: ignore[import-not-found]

from observer_lab.course.scenes import Choose
from observer_lab.lessons import LESSONS

LESSON, NAME, KNOB = "duality", "sensor", "sensor turned by [°]"
EVERY_S = 0.25  # s between two moves
TICK = os.sysconf("SC_CLK_TCK")
SHOWN = re.compile(r"<dd>(-?[\d.]+) °</dd>")


class Tab(WirePage):  # type: ignore[misc]
    """A tab whose messages are read as they come."""

    def __init__(self, socket: ClientConnection) -> None:
        super().__init__(plays=True)
        self.socket, self.sources = socket, list[str]()

    def send_raw(self, data: bytes | str) -> None:
        self._sending = asyncio.ensure_future(self.socket.send(data))

    async def read(self, seen: Any = None) -> None:
        async for data in self.socket:
            if seen is not None:
                seen(data)
            for message in unpack(data)[0]:
                self.sources.append(message.get("source", ""))
                self.take(message)

    async def until(self, condition: Any) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, "it never came"
            await asyncio.sleep(0.01)

    def part(self, opening: str) -> str:
        return next((str(w["props"]["content"]) for w in self.widgets.values()
                     if str(w["props"].get("content")).startswith(opening)), "")


async def enter(url: str, path: str = "", word: str = "") -> Tab:
    place = urlsplit(url)
    headers = [("Authorization", f"Bearer {word}")] if word else []
    socket = await connect(f"ws://{place.netloc}{path}", subprotocols=[Subprotocol(f"viser-v{version('viser')}")], max_size=None,
                           compression=None, additional_headers=headers, open_timeout=PATIENCE)
    tab = Tab(socket)
    tab.look()
    return tab


def seconds_of(process: int) -> float:
    """The processor's time of a process and its children so far."""
    family, total = [process], 0.0
    for each in family:
        children = Path(f"/proc/{each}/task/{each}/children").read_text(encoding="ascii").split()
        family += map(int, children)
        fields = Path(f"/proc/{each}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
        total += (int(fields[11]) + int(fields[12])) / TICK
    return total


class Watch:
    """When each follower got which value. The same bytes are read once."""

    def __init__(self) -> None:
        self.values: dict[bytes, float | None] = {}
        self.came: list[list[tuple[float, float]]] = []

    def follower(self) -> Any:
        seen: list[tuple[float, float]] = []
        self.came.append(seen)

        def heard(data: bytes) -> None:
            now = time.perf_counter()
            if data not in self.values:
                found = [SHOWN.search(str(m.get("updates", {}).get("content", ""))) for m in unpack(data)[0]]
                self.values[data] = next((float(each[1]) for each in found if each), None)
            value = self.values[data]
            if value is not None:
                seen.append((now, value))
        return heard


async def measure(url: str, word: str, process: int, options: argparse.Namespace) -> dict[str, float]:
    presenter = await enter(url, word=word)
    tasks = [asyncio.ensure_future(presenter.read())]
    await presenter.until(lambda: presenter.part('<div class="ol-head'))

    def ask(value: str) -> None:
        hand = re.search(r'data-to="([^"]+)"', presenter.part('<div class="ol-head'))
        assert hand is not None
        presenter.send("GuiUpdateMessage", uuid=hand[1], updates={"value": value})
    path = [scene.id for scene in LESSONS[LESSON].path]
    scene = next(k for k, each in enumerate(LESSONS[LESSON].path) if NAME in each.knobs)
    question = next(k for k, each in enumerate(LESSONS[LESSON].path) if isinstance(each.do, Choose))
    ask(f"scene:{scene}")
    await presenter.until(lambda: f'data-scene="{path[scene]}"' in presenter.part('<section class="ol-card'))
    first = await enter(url)
    tasks.append(asyncio.ensure_future(first.read()))
    await first.until(lambda: f'data-scene="{path[scene]}"' in first.part('<section class="ol-card'))
    watch, followers = Watch(), [await enter(url) for _ in range(options.followers)]
    arrived: Counter[int] = Counter()

    async def follow(k: int, tab: Tab) -> None:
        heard = watch.follower()
        async for data in tab.socket:
            arrived[k] += 1
            heard(data)
    tasks += [asyncio.ensure_future(follow(k, tab)) for k, tab in enumerate(followers)]
    while len(arrived) < options.followers or min(arrived.values()) < 2:
        await asyncio.sleep(0.05)
    await asyncio.sleep(3.0)
    asked, before = [], seconds_of(process)
    for k in range(1, options.moves + 1):
        value = float(k % 2 * 40 + k % 37 + 1)
        asked.append((time.perf_counter(), value))
        presenter.send("GuiUpdateMessage", uuid=presenter.find(KNOB), updates={"value": value})
        await asyncio.sleep(EVERY_S)
    await asyncio.sleep(3.0)
    spent = seconds_of(process) - before
    waits, lost = [], 0
    for seen in watch.came:
        for k, (t, value) in enumerate(asked):
            end = asked[k + 1][0] if k + 1 < len(asked) else float("inf")
            came = next((at for at, which in seen if at >= t and which == value), None)
            lost += came is None and end == float("inf")
            waits.append(np.nan if came is None else came - t)
    ask(f"scene:{question}")
    ask("vote:open")
    await first.until(lambda: 'data-room="vote:' in first.part('<section class="ol-card'))
    vote = re.search(r'data-room="vote:(\d+):0"', first.part('<section class="ol-card'))
    hand = next(found[1] for source in first.sources if (found := re.search(r'"hand": "([^"]+)"', source)) and "// room.js" in source)
    assert vote is not None
    begun = time.perf_counter()
    for k in range(options.followers):
        first.send("GuiUpdateMessage", uuid=hand, updates={"value": f"vote:{vote[1]}:{k % 3}:ballot{k:06d}"})
        if k % 50 == 49:
            await asyncio.sleep(0.1)  # a connection has a bound of messages
    await first.until(lambda: sum("is counted" in note for note in first.notes) >= options.followers)
    voted = time.perf_counter() - begun
    for task in tasks:
        task.cancel()
    for tab in (presenter, first, *followers):
        await tab.socket.close()
    known = np.array(waits)[~np.isnan(waits)]
    return {"followers": options.followers, "median ms": 1e3 * float(np.median(known)), "p95 ms": 1e3 * float(np.percentile(known, 95)),
            "moves not seen by the next one's": float(np.isnan(waits).mean()), "last move lost": lost,
            "server ms per follower and move": 1e3 * spent / options.moves / options.followers, "votes s": voted}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, usual in (("followers", 100), ("moves", 40), ("workers", 2)):
        parser.add_argument(f"--{name}", type=int, default=usual)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "observer_lab", "serve", "--room", "--port", "0", "--data-dir", folder, "--lesson", LESSON,
                   "--workers", str(options.workers), "--max-sessions", "1000"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=HERE) as server:
            assert server.stdout is not None
            url, told = server.stdout.readline().strip(), server.stdout.readline()
            try:
                found = asyncio.run(measure(url, told.partition("?present=")[2].strip(), server.pid, options))
            finally:
                server.terminate()
    for name, value in found.items():
        print(f"{name:36} {value:.4g}")


if __name__ == "__main__":
    main()
